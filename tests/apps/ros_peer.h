#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "ros/ros_types.h"

namespace highwall::ros_node_test {

// What a node has published so far.
struct Heard {
  std::map<Stamp, apps::UncertainPose> poses, odometry;
  std::map<Stamp, Pose> T_WO, T_OB;  // by tf
  std::string state, base;           // the last ones
  std::size_t states = 0, paths = 0, grids = 0;
  std::size_t cloud_points = 0, path_poses = 0;  // of the last ones
  apps::OctreeMessage octree;                    // the last one
};

// The other side of highwall_ros: a camera with an IMU that listens to its node. The messages of
// ROS 1 need C++17, which this header is too.
class RosPeer {
 public:
  // Waits for the master that ROS_MASTER_URI names. Throws std::runtime_error if there is none.
  RosPeer();
  ~RosPeer();
  RosPeer(const RosPeer&) = delete;
  RosPeer& operator=(const RosPeer&) = delete;

  static void SetParameter(const std::string& name, const std::string& value);
  static void SetParameter(const std::string& name, bool value);
  static void SetParameter(const std::string& name, int value);

  // Publishes the camera, latched, and waits until the node listens to everything and can be heard;
  // false after 30 s.
  bool WaitForNode(const PinholeCamera& camera, const std::string& frame, bool with_imu) const;
  void PublishImages(Stamp stamp, const cv::Mat& bgr, const cv::Mat& depth) const;
  void PublishImu(Stamp stamp, const Eigen::Vector3d& gyroscope,
                  const Eigen::Vector3d& accelerometer) const;
  Heard heard() const;

  static apps::Answer Call(const std::string& service);
  static apps::Answer Call(const std::string& service, bool value);
  // Asks a node to shut down, as `rosnode kill` does.
  static void Shutdown(const std::string& node);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace highwall::ros_node_test
