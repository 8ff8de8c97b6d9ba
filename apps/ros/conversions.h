#pragma once

#include <diagnostic_msgs/DiagnosticArray.h>
#include <geometry_msgs/Pose.h>
#include <geometry_msgs/PoseWithCovariance.h>
#include <geometry_msgs/Transform.h>
#include <geometry_msgs/TwistWithCovariance.h>
#include <nav_msgs/OccupancyGrid.h>
#include <nav_msgs/Path.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/PointCloud2.h>
#include <std_msgs/Header.h>

#include <string>
#include <vector>

#include "ros/octomap_message.h"
#include "ros/ros_types.h"

// Between messages of ROS and types of Highwall.
namespace highwall::apps {

ros::Time ToRos(Stamp stamp);
Stamp FromRos(const ros::Time& time);

geometry_msgs::Pose ToRosPose(const Pose& pose);
geometry_msgs::Transform ToRosTransform(const Pose& pose);
Pose FromRos(const geometry_msgs::Transform& transform);
geometry_msgs::PoseWithCovariance ToRos(const UncertainPose& pose);
geometry_msgs::TwistWithCovariance ToRos(const Twist& twist);

// Returns the image as CV_8UC3 in the order blue, green, red: of bgr8, rgb8, bgra8, rgba8, mono8.
// Throws InvalidArgument for another encoding, and for data that do not fill the image.
cv::Mat ColourOf(const sensor_msgs::Image& message);
// Returns the image as it was sent: CV_16UC1 of 16UC1 and mono16, CV_32FC1 of 32FC1. Throws
// likewise.
cv::Mat DepthOf(const sensor_msgs::Image& message);
// Returns the camera of the raw images, or of the rectified ones, which P describes. Throws
// InvalidArgument for a lens model that Highwall does not have, and a camera that is not valid.
CameraInfo CameraOf(const sensor_msgs::CameraInfo& message, bool rectified);

nav_msgs::Path ToRos(const Trajectory& trajectory, const std_msgs::Header& header);
diagnostic_msgs::DiagnosticArray ToRos(const StateReport& state, const std_msgs::Header& header);
sensor_msgs::PointCloud2 ToRos(const std::vector<ColouredPoint>& points,
                               const std_msgs::Header& header);
nav_msgs::OccupancyGrid ToRos(const NavigationGrid& grid, const std_msgs::Header& header);
OctomapMessage ToRos(const OctreeMessage& octree, const std_msgs::Header& header);

}  // namespace highwall::apps
