#pragma once

#include <map>
#include <optional>

#include <highwall/frontend/input/live_camera.h>
#include <highwall/frontend/system/slam_system.h>

// Knows where the camera is, and where it has been.
class Pilot {
 public:
  // No camera waits for an adjustment.
  explicit Pilot(const highwall::RgbdSensor& sensor) : slam_(sensor, {.mapper = {.wait = false}}) {
    slam_.SetCallbacks(
        {.on_keyframe = [this](
                            const highwall::KeyFrame& keyframe,
                            const highwall::RgbdImage&) { places_[keyframe.id] = keyframe.T_WC; },
         .on_loop = [this](const highwall::LoopReport& loop) { returns_ += loop.accepted; },
         .on_map =
             [this](const highwall::Map& map) {
               for (auto& [id, T_WC] : places_) T_WC = map.ResolvePose(id);
             },
         .on_frame =
             [this](const highwall::FrameResult& frame) {
               here_.reset();
               if (HasPose(frame.state)) here_ = frame.T_WC;
             }});
  }

  // Tracks until the camera is switched off. Returns how many images came too fast.
  std::size_t Run(highwall::ImageSource& device) {
    highwall::LiveCamera camera(device);
    while (const auto image = camera.Next()) slam_.Track(*image);
    slam_.Finish();
    return camera.dropped();
  }

  const std::optional<highwall::Pose>& here() const { return here_; }
  const std::map<highwall::KeyFrameId, highwall::Pose>& places() const { return places_; }
  highwall::Trajectory path() const { return slam_.trajectory(); }
  int returns() const { return returns_; }

 private:
  highwall::SlamSystem slam_;
  std::optional<highwall::Pose> here_;                     // T_WC, empty where lost
  std::map<highwall::KeyFrameId, highwall::Pose> places_;  // T_WC of keyframes
  int returns_ = 0;                                        // to places seen before
};
