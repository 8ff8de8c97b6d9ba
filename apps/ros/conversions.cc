#include "ros/conversions.h"

#include <sensor_msgs/image_encodings.h>
#include <sensor_msgs/point_cloud2_iterator.h>

#include <algorithm>
#include <cstring>

#include <opencv2/imgproc.hpp>

#include <highwall/core/error.h>

namespace highwall::apps {
namespace {

namespace encodings = sensor_msgs::image_encodings;

constexpr Stamp kSecond = 1'000'000'000;  // [ns]

template <class Array>
void CopyRows(const PoseCovariance& covariance, Array* out) {
  for (int row = 0; row < 6; ++row) {
    for (int column = 0; column < 6; ++column) {
      (*out)[static_cast<std::size_t>(6 * row + column)] = covariance(row, column);
    }
  }
}

// Returns a view of the message, which the message owns.
cv::Mat ViewOf(const sensor_msgs::Image& message, int type) {
  const std::size_t row = message.width * CV_ELEM_SIZE(type);
  if (message.width == 0 || message.height == 0 || message.step < row ||
      message.data.size() / message.step < message.height) {
    throw InvalidArgument("an image of " + std::to_string(message.width) + " x " +
                          std::to_string(message.height) + " in " + message.encoding + " has " +
                          std::to_string(message.data.size()) + " bytes, too few");
  }
  if (message.is_bigendian && CV_ELEM_SIZE1(type) > 1) {
    throw InvalidArgument("an image is big-endian: publish it little-endian");
  }
  auto* const data = const_cast<std::uint8_t*>(message.data.data());  // only read
  return {static_cast<int>(message.height), static_cast<int>(message.width), type, data,
          message.step};
}

template <class Coefficients>
void SetLens(const Coefficients& D, std::initializer_list<double PinholeCamera::*> names,
             PinholeCamera* camera) {
  auto value = D.begin();
  for (double PinholeCamera::*const name : names) {
    if (value == D.end()) return;
    camera->*name = *value++;
  }
}

}  // namespace

ros::Time ToRos(Stamp stamp) {
  ros::Time time;
  return time.fromNSec(static_cast<std::uint64_t>(std::max<Stamp>(stamp, 0)));
}

Stamp FromRos(const ros::Time& time) {
  return static_cast<Stamp>(time.sec) * kSecond + static_cast<Stamp>(time.nsec);
}

geometry_msgs::Pose ToRosPose(const Pose& pose) {
  geometry_msgs::Pose message;
  message.position.x = pose.p().x();
  message.position.y = pose.p().y();
  message.position.z = pose.p().z();
  message.orientation.x = pose.q().x();
  message.orientation.y = pose.q().y();
  message.orientation.z = pose.q().z();
  message.orientation.w = pose.q().w();
  return message;
}

geometry_msgs::Transform ToRosTransform(const Pose& pose) {
  const geometry_msgs::Pose same = ToRosPose(pose);
  geometry_msgs::Transform message;
  message.translation.x = same.position.x;
  message.translation.y = same.position.y;
  message.translation.z = same.position.z;
  message.rotation = same.orientation;
  return message;
}

Pose FromRos(const geometry_msgs::Transform& transform) {
  const auto& q = transform.rotation;
  const auto& p = transform.translation;
  return Pose(Eigen::Quaterniond(q.w, q.x, q.y, q.z), Eigen::Vector3d(p.x, p.y, p.z));
}

geometry_msgs::PoseWithCovariance ToRos(const UncertainPose& pose) {
  geometry_msgs::PoseWithCovariance message;
  message.pose = ToRosPose(pose.pose);
  CopyRows(pose.covariance, &message.covariance);
  return message;
}

geometry_msgs::TwistWithCovariance ToRos(const Twist& twist) {
  geometry_msgs::TwistWithCovariance message;
  message.twist.linear.x = twist.velocity[0];
  message.twist.linear.y = twist.velocity[1];
  message.twist.linear.z = twist.velocity[2];
  message.twist.angular.x = twist.velocity[3];
  message.twist.angular.y = twist.velocity[4];
  message.twist.angular.z = twist.velocity[5];
  CopyRows(twist.covariance, &message.covariance);
  return message;
}

cv::Mat ColourOf(const sensor_msgs::Image& message) {
  const std::string& encoding = message.encoding;
  cv::Mat bgr;
  if (encoding == encodings::BGR8 || encoding == encodings::TYPE_8UC3) {
    return ViewOf(message, CV_8UC3).clone();
  }
  if (encoding == encodings::RGB8) {
    cv::cvtColor(ViewOf(message, CV_8UC3), bgr, cv::COLOR_RGB2BGR);
  } else if (encoding == encodings::BGRA8) {
    cv::cvtColor(ViewOf(message, CV_8UC4), bgr, cv::COLOR_BGRA2BGR);
  } else if (encoding == encodings::RGBA8) {
    cv::cvtColor(ViewOf(message, CV_8UC4), bgr, cv::COLOR_RGBA2BGR);
  } else if (encoding == encodings::MONO8) {
    cv::cvtColor(ViewOf(message, CV_8UC1), bgr, cv::COLOR_GRAY2BGR);
  } else {
    throw InvalidArgument("colour images are " + encoding +
                          ": publish bgr8, rgb8, bgra8, rgba8 or mono8");
  }
  return bgr;
}

cv::Mat DepthOf(const sensor_msgs::Image& message) {
  const std::string& encoding = message.encoding;
  if (encoding == encodings::TYPE_16UC1 || encoding == encodings::MONO16) {
    return ViewOf(message, CV_16UC1).clone();
  }
  if (encoding == encodings::TYPE_32FC1) return ViewOf(message, CV_32FC1).clone();
  throw InvalidArgument("depth images are " + encoding + ": publish 16UC1 or 32FC1");
}

CameraInfo CameraOf(const sensor_msgs::CameraInfo& message, bool rectified) {
  CameraInfo info;
  info.frame = message.header.frame_id;
  PinholeCamera& camera = info.camera;
  camera.width = static_cast<int>(message.width);
  camera.height = static_cast<int>(message.height);
  if (rectified) {
    camera.fx = message.P[0];
    camera.cx = message.P[2];
    camera.fy = message.P[5];
    camera.cy = message.P[6];
  } else {
    camera.fx = message.K[0];
    camera.cx = message.K[2];
    camera.fy = message.K[4];
    camera.cy = message.K[5];
    using C = PinholeCamera;
    const std::string& model = message.distortion_model;
    if (model == "equidistant" || model == "fisheye") {
      camera.lens = LensModel::kEquidistant;
      SetLens(message.D, {&C::k1, &C::k2, &C::k3, &C::k4}, &camera);
    } else if (model.empty() || model == "plumb_bob" || model == "rational_polynomial") {
      SetLens(message.D, {&C::k1, &C::k2, &C::p1, &C::p2, &C::k3, &C::k4, &C::k5, &C::k6}, &camera);
    } else if (std::any_of(message.D.begin(), message.D.end(), [](double k) { return k != 0.0; })) {
      throw InvalidArgument("camera_info has the lens model " + model +
                            ": use plumb_bob, rational_polynomial or equidistant");
    }
  }
  camera.Validate();
  return info;
}

nav_msgs::Path ToRos(const Trajectory& trajectory, const std_msgs::Header& header) {
  nav_msgs::Path message;
  message.header = header;
  message.poses.reserve(trajectory.size());
  for (const StampedPose& stamped : trajectory) {
    geometry_msgs::PoseStamped pose;
    pose.header = header;
    pose.header.stamp = ToRos(stamped.stamp);
    pose.pose = ToRosPose(stamped.pose);
    message.poses.push_back(pose);
  }
  return message;
}

diagnostic_msgs::DiagnosticArray ToRos(const StateReport& state, const std_msgs::Header& header) {
  diagnostic_msgs::DiagnosticStatus status;
  status.level = static_cast<std::int8_t>(state.level);
  status.name = "highwall: tracking";
  status.hardware_id = "highwall";
  status.message = state.message;
  for (const auto& [key, text] : state.values) {
    diagnostic_msgs::KeyValue value;
    value.key = key;
    value.value = text;
    status.values.push_back(value);
  }
  diagnostic_msgs::DiagnosticArray message;
  message.header = header;
  message.status.push_back(status);
  return message;
}

sensor_msgs::PointCloud2 ToRos(const std::vector<ColouredPoint>& points,
                               const std_msgs::Header& header) {
  sensor_msgs::PointCloud2 message;
  message.header = header;
  sensor_msgs::PointCloud2Modifier modifier(message);
  modifier.setPointCloud2FieldsByString(2, "xyz", "rgb");
  modifier.resize(points.size());
  message.is_dense = true;
  sensor_msgs::PointCloud2Iterator<float> p(message, "x");
  sensor_msgs::PointCloud2Iterator<std::uint8_t> rgb(message, "rgb");  // b, g, r in memory
  for (const ColouredPoint& point : points) {
    for (std::size_t i = 0; i < 3; ++i) p[i] = point.p[static_cast<Eigen::Index>(i)];
    rgb[0] = point.blue;
    rgb[1] = point.green;
    rgb[2] = point.red;
    ++p;
    ++rgb;
  }
  return message;
}

nav_msgs::OccupancyGrid ToRos(const NavigationGrid& grid, const std_msgs::Header& header) {
  nav_msgs::OccupancyGrid message;
  message.header = header;
  message.info.map_load_time = header.stamp;
  message.info.resolution = static_cast<float>(grid.resolution);
  message.info.width = static_cast<std::uint32_t>(grid.width);
  message.info.height = static_cast<std::uint32_t>(grid.height);
  message.info.origin = ToRosPose(grid.T_WG);
  message.data = grid.cells;
  return message;
}

OctomapMessage ToRos(const OctreeMessage& octree, const std_msgs::Header& header) {
  OctomapMessage message;
  message.header = header;
  message.resolution = octree.resolution;
  message.data = octree.data;
  return message;
}

}  // namespace highwall::apps
