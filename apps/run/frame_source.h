#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <highwall/frontend/input/dataset.h>
#include <highwall/frontend/input/frame_reader.h>
#include <highwall/frontend/input/image_source.h>
#include <highwall/frontend/system/slam_system.h>
#include <highwall/internal/run_profile.h>

#include "run/live_replay.h"
#include "run/slam_run.h"

namespace highwall::apps {

// A dataset without frames, in the place of that of a camera.
class NoDataset final : public Dataset {
 public:
  std::size_t size() const override { return 0; }
  Stamp stamp(std::size_t) const override { return 0; }
  const Trajectory* groundtruth() const override { return nullptr; }

 private:
  RgbdImage DoLoad(std::size_t) const override { return {}; }
};

// Frames of a run: of a dataset, on request or at the pace of their stamps, or of a camera.
class FrameSource {
 public:
  // camera: null, or in the place of the dataset.
  FrameSource(const Dataset& dataset, ImageSource* camera, const SlamRunOptions& options,
              RunProfile* profile);

  // Throws as the reader, and as the camera unless that has given an image: a run has results then.
  std::optional<RgbdImage> Next();
  // Number of frames so far, including unusable and dropped ones, and of all of them: of a camera,
  // those so far.
  std::size_t position() const;
  std::size_t count() const;
  std::size_t dropped() const;
  // Number of frames after the last one returned.
  std::size_t left() const;
  // Number of frames that are late.
  std::size_t waiting() const;
  // What ended the camera, if that failed after its first image; else empty.
  const std::string& failure() const { return failure_; }

  // Measures the time since the frame of this stamp arrived, if frames come at their pace.
  void Measure(Stamp stamp);
  // [ms] from the arrival of each frame to its result.
  const std::vector<double>& delays() const { return delays_; }

 private:
  RunProfile* const profile_;
  ImageSource* const camera_;
  std::optional<FrameReader> reader_;  // one of the three
  std::optional<LiveReplay> live_;
  std::size_t taken_ = 0;  // from the camera
  std::string failure_;
  std::vector<double> delays_;
};

// Passes the IMU readings of a recording, or of a camera, to the system before each image.
class ImuReplay {
 public:
  // camera: null for a recording.
  ImuReplay(const std::optional<ImuFeed>& feed, ImageSource* camera)
      : feed_(feed), camera_(camera) {}

  void FeedUntil(Stamp image, SlamSystem& slam);

 private:
  const std::optional<ImuFeed>& feed_;
  ImageSource* const camera_;
  std::size_t next_ = 0;
};

}  // namespace highwall::apps
