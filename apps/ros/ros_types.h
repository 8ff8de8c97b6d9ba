#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include <highwall/core/camera.h>
#include <highwall/core/pose.h>
#include <highwall/core/stamp.h>
#include <highwall/core/trajectory.h>

// What passes between ROS and the node, in types of Highwall. The messages of ROS 1 are C++17 (they
// use std::allocator::rebind), Highwall is C++20: this header is both, and so is ros_link.h.
namespace highwall::apps {

using PoseCovariance = Eigen::Matrix<double, 6, 6>;

// A pose with the covariance of its position [m] and rotation [rad], both along the axes of the
// frame in which it is.
struct UncertainPose {
  Pose pose;
  PoseCovariance covariance = PoseCovariance::Identity();
};

// Motion along and about the axes of the moving frame, [m/s, rad/s].
struct Twist {
  Eigen::Matrix<double, 6, 1> velocity = Eigen::Matrix<double, 6, 1>::Zero();
  PoseCovariance covariance = PoseCovariance::Identity();
};

struct CameraInfo {
  PinholeCamera camera;
  std::string frame;  // of its images
};

enum class StateLevel { kOk = 0, kWarning = 1, kError = 2 };  // as in diagnostic_msgs

// State of tracking for a person.
struct StateReport {
  StateLevel level = StateLevel::kOk;
  std::string message;
  std::vector<std::pair<std::string, std::string>> values;  // by their names
};

struct ColouredPoint {
  Eigen::Vector3f p = Eigen::Vector3f::Zero();  // [m]
  std::uint8_t red = 0, green = 0, blue = 0;
};

// A grid as nav_msgs/OccupancyGrid has it: -1 unknown, 0 free, 100 occupied, row by row.
struct NavigationGrid {
  int width = 0, height = 0;
  double resolution = 0.0;  // [m]
  Pose T_WG;                // of its corner
  std::vector<std::int8_t> cells;
};

// A binary octree as octomap_msgs/Octomap has it.
struct OctreeMessage {
  double resolution = 0.0;  // [m]
  std::vector<std::int8_t> data;
};

// Answer of a service.
struct Answer {
  bool success = false;
  std::string message;
};

// Values of parameters by their paths, such as "set.tracker.moving.enabled".
using Parameters = std::map<std::string, std::string>;

}  // namespace highwall::apps
