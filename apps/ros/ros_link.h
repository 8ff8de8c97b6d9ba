#pragma once

#include <memory>
#include <string>
#include <vector>

#include "ros/ros_types.h"

namespace highwall::apps {

// Receives what arrives from ROS. Images, camera and IMU come on one thread, services on another.
class RosListener {
 public:
  RosListener() = default;
  virtual ~RosListener() = default;
  RosListener(const RosListener&) = delete;
  RosListener& operator=(const RosListener&) = delete;

  virtual void OnCamera(const CameraInfo& info) = 0;
  virtual void OnColour(Stamp stamp, const cv::Mat& bgr) = 0;    // CV_8UC3
  virtual void OnDepth(Stamp stamp, const cv::Mat& stored) = 0;  // CV_16UC1 or CV_32FC1
  virtual void OnImu(Stamp stamp, const Eigen::Vector3d& gyroscope,
                     const Eigen::Vector3d& accelerometer) = 0;
  // An image that cannot be used, and the reason.
  virtual void OnProblem(const std::string& what) = 0;

  virtual Answer OnSave() = 0;
  virtual Answer OnReset() = 0;
  virtual Answer OnLocalize(bool localize) = 0;
};

// Names of frames.
struct RosFrames {
  std::string map = "map", odom = "odom";
  std::string base;  // empty: the frame of the images
};

struct RosLinkOptions {
  RosFrames frames;
  bool rectified = false;  // images are: camera_info states their camera by P
  bool imu = true;         // whether it is subscribed to
};

// The connection of a process with ROS 1: topics, services, transforms and parameters
// (docs/ros.md). Publishing is possible on any thread.
class RosLink {
 public:
  // Takes remappings from the arguments; signals are left to the caller.
  static void Init(int& argc, char** argv);
  // Throws InvalidArgument if no master can be reached; it waits for none.
  RosLink();
  // Ends all threads and the connection.
  ~RosLink();
  RosLink(const RosLink&) = delete;
  RosLink& operator=(const RosLink&) = delete;

  // Private parameters of the node. Throws InvalidArgument for a value that is not a number, a
  // text or a boolean.
  Parameters parameters() const;
  // False once ROS has shut the node down.
  bool ok() const;

  // Advertises, and subscribes to the camera's description. listener: must outlive this object.
  void Start(const RosLinkOptions& options, RosListener& listener);
  // Subscribes to images and readings, once.
  void Receive();
  // Receives nothing more.
  void Stop();

  // Returns T_BC, the pose of the images' frame in the base frame, from tf; the identity if both
  // are the same. Waits for it for `seconds`; empty if it is not known by then.
  std::optional<Pose> T_BC(const std::string& image_frame, double seconds) const;

  // Publish in the frame map, or in odom, the base at the time of an image. T_WO: the frame odom.
  void PublishTransforms(Stamp stamp, const std::string& base, const Pose& T_WO, const Pose& T_OB);
  void PublishPose(Stamp stamp, const UncertainPose& T_WB);
  void PublishOdometry(Stamp stamp, const std::string& base, const UncertainPose& T_OB,
                       const Twist& twist);
  void PublishState(Stamp stamp, const StateReport& state);
  // Latched, in the frame map.
  void PublishPath(Stamp stamp, const Trajectory& T_WB);
  void PublishCloud(Stamp stamp, const std::vector<ColouredPoint>& points);
  void PublishOctree(Stamp stamp, const OctreeMessage& octree);
  void PublishGrid(Stamp stamp, const NavigationGrid& grid);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace highwall::apps
