#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include <highwall/core/trajectory.h>
#include <highwall/frontend/input/sensor.h>
#include <highwall/mapping/depth_camera.h>

#include "ros/camera_stream.h"
#include "ros/odometry_frame.h"
#include "ros/pose_covariance.h"
#include "ros/ros_link.h"
#include "ros/turn.h"
#include "run/run_observer.h"
#include "run/slam_run.h"
#include "view/scene_text.h"

namespace highwall::apps {

struct RunPublisherOptions {
  RgbdSensor sensor;
  Pose T_BC;                  // the images' frame in the base frame
  std::string base;           // its name
  double period = 1.0;        // [s] > 0 between two publications of path, cloud, octree and grid
  double max_depth = 6.0;     // [m] > 0 of the points of the cloud
  std::filesystem::path map;  // of the service that saves; empty: nothing can be saved
};

// Publishes a run while it lasts. OnFrame() and OnKeyframes() are called on the thread that tracks,
// OnOctree() on the one that maps, Save() on that of the services.
class RunPublisher final : public RunObserver {
 public:
  // link, stream: must outlive this object.
  RunPublisher(RosLink& link, const CameraStream& stream, RunPublisherOptions options);

  void OnFrame(const FrameResult& result, const RgbdImage& image, const SlamSystem& slam,
               const RunPosition& position) override;
  void OnKeyframes(const KeyframeEvent& event) override;
  void OnOctree(std::int32_t world, const OctomapBuilder& octree) override;

  // Saves the map so far, after the next frame. Waits for it for ten seconds at most.
  Answer Save();
  // Publishes the final path, cloud, octree and grid.
  void Finish(const SlamRun& run);

 private:
  struct Keyframe {
    KeyframeCloudSample sample;
    KeyframePlace place;
  };

  void PublishFrame(const FrameResult& result, const Pose& T_OB);
  void PublishState(const FrameResult& result, const SlamSystem& slam, const RunPosition& position);
  void PublishPath(const Trajectory& T_WC) const;
  void PublishCloud();
  void PublishGrid(const OccupancyGrid& grid, const Pose& T_WG) const;
  void SaveIfAsked(const SlamSystem& slam);
  void Reply(const Answer& answer);

  RosLink& link_;
  const CameraStream& stream_;
  const RunPublisherOptions options_;
  const DepthUnprojector unprojector_;
  OdometryFrame odometry_;
  std::atomic<Stamp> stamp_ = 0;          // of the last frame
  std::atomic<std::int32_t> world_ = -1;  // in which it has a pose
  std::optional<StampedPose> last_;       // T_OB
  std::optional<std::string> message_;    // of the last state
  std::optional<Stamp> reported_;         // when it was published
  std::map<std::int64_t, Keyframe> keyframes_;
  bool cloud_changed_ = false;
  Turn path_turn_, cloud_turn_, octree_turn_;
  std::atomic<bool> save_ = false;
  std::mutex mutex_;  // of the following
  std::condition_variable saved_;
  std::optional<Answer> answer_;
};

}  // namespace highwall::apps
