#include "ros_peer.h"

#include <diagnostic_msgs/DiagnosticArray.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <nav_msgs/OccupancyGrid.h>
#include <nav_msgs/Odometry.h>
#include <nav_msgs/Path.h>
#include <ros/network.h>
#include <ros/ros.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/PointCloud2.h>
#include <sensor_msgs/image_encodings.h>
#include <std_srvs/SetBool.h>
#include <std_srvs/Trigger.h>
#include <tf2_msgs/TFMessage.h>
#include <xmlrpcpp/XmlRpcClient.h>

#include <mutex>
#include <stdexcept>
#include <utility>

#include "ros/conversions.h"

namespace highwall::ros_node_test {
namespace {

constexpr double kTimeout = 30.0;  // [s]
constexpr double kPoll = 0.02;     // [s]

// Starts ROS in this process, once.
void StartRos() {
  if (ros::isInitialized()) return;
  ros::init(ros::M_string(), "peer", ros::init_options::NoSigintHandler);
  for (double waited = 0.0; !ros::master::check(); waited += kPoll) {
    if (waited > kTimeout) throw std::runtime_error("there is no master");
    ros::WallDuration(kPoll).sleep();
  }
}

apps::UncertainPose PoseOf(const geometry_msgs::PoseWithCovariance& message) {
  const auto& p = message.pose.position;
  const auto& q = message.pose.orientation;
  apps::UncertainPose pose{Pose(Eigen::Quaterniond(q.w, q.x, q.y, q.z), {p.x, p.y, p.z}), {}};
  for (int i = 0; i < 36; ++i) {
    pose.covariance(i / 6, i % 6) = message.covariance[static_cast<std::size_t>(i)];
  }
  return pose;
}

sensor_msgs::Image MessageOf(Stamp stamp, const cv::Mat& image, const std::string& encoding) {
  sensor_msgs::Image message;
  message.header.stamp = apps::ToRos(stamp);
  message.encoding = encoding;
  message.width = static_cast<std::uint32_t>(image.cols);
  message.height = static_cast<std::uint32_t>(image.rows);
  message.step = static_cast<std::uint32_t>(image.step);
  message.data.assign(image.datastart, image.dataend);
  return message;
}

}  // namespace

struct RosPeer::Impl {
  template <class Message, class Handle>
  void Hear(const char* topic, Handle handle) {
    const boost::function<void(const boost::shared_ptr<const Message>&)> locked =
        [this, handle](const boost::shared_ptr<const Message>& message) {
          const std::lock_guard<std::mutex> lock(mutex);
          handle(*message);
        };
    subscribers.push_back(node.subscribe<Message>(topic, 10'000, locked));
  }
  void HearAll();

  ros::NodeHandle node;
  ros::Publisher info{node.advertise<sensor_msgs::CameraInfo>("rgb/camera_info", 1, true)};
  ros::Publisher colour{node.advertise<sensor_msgs::Image>("rgb/image", 1000)};
  ros::Publisher depth{node.advertise<sensor_msgs::Image>("depth/image", 1000)};
  ros::Publisher imu{node.advertise<sensor_msgs::Imu>("imu", 100'000)};
  std::vector<ros::Subscriber> subscribers;
  mutable std::mutex mutex;
  Heard heard;
  ros::AsyncSpinner spinner{1};
};

void RosPeer::Impl::HearAll() {
  Hear<geometry_msgs::PoseWithCovarianceStamped>(
      "highwall/pose", [this](const geometry_msgs::PoseWithCovarianceStamped& message) {
        heard.poses[apps::FromRos(message.header.stamp)] = PoseOf(message.pose);
      });
  Hear<nav_msgs::Odometry>("highwall/odometry", [this](const nav_msgs::Odometry& message) {
    heard.odometry[apps::FromRos(message.header.stamp)] = PoseOf(message.pose);
    heard.base = message.child_frame_id;
  });
  Hear<tf2_msgs::TFMessage>("/tf", [this](const tf2_msgs::TFMessage& message) {
    for (const geometry_msgs::TransformStamped& transform : message.transforms) {
      auto& poses = transform.header.frame_id == "map" ? heard.T_WO : heard.T_OB;
      poses[apps::FromRos(transform.header.stamp)] = apps::FromRos(transform.transform);
    }
  });
  Hear<diagnostic_msgs::DiagnosticArray>("/diagnostics",
                                         [this](const diagnostic_msgs::DiagnosticArray& message) {
                                           ++heard.states;
                                           heard.state = message.status.at(0).message;
                                         });
  Hear<nav_msgs::Path>("highwall/path", [this](const nav_msgs::Path& message) {
    ++heard.paths;
    heard.path_poses = message.poses.size();
  });
  Hear<sensor_msgs::PointCloud2>("highwall/cloud", [this](const sensor_msgs::PointCloud2& message) {
    heard.cloud_points = message.width * message.height;
  });
  Hear<nav_msgs::OccupancyGrid>("highwall/grid",
                                [this](const nav_msgs::OccupancyGrid&) { ++heard.grids; });
  Hear<apps::OctomapMessage>("highwall/octomap", [this](const apps::OctomapMessage& message) {
    heard.octree = {message.resolution, message.data};
  });
}

RosPeer::RosPeer() {
  StartRos();
  impl_ = std::make_unique<Impl>();
  impl_->HearAll();
  impl_->spinner.start();
}

RosPeer::~RosPeer() {
  impl_.reset();
  ros::shutdown();
}

void RosPeer::SetParameter(const std::string& name, const std::string& value) {
  StartRos();
  ros::param::set(name, value);
}

void RosPeer::SetParameter(const std::string& name, bool value) {
  StartRos();
  ros::param::set(name, value);
}

void RosPeer::SetParameter(const std::string& name, int value) {
  StartRos();
  ros::param::set(name, value);
}

bool RosPeer::WaitForNode(const PinholeCamera& camera, const std::string& frame,
                          bool with_imu) const {
  sensor_msgs::CameraInfo message;
  message.header.frame_id = frame;
  message.width = static_cast<std::uint32_t>(camera.width);
  message.height = static_cast<std::uint32_t>(camera.height);
  message.distortion_model = "plumb_bob";
  message.D.assign({camera.k1, camera.k2, camera.p1, camera.p2, camera.k3});
  message.K = {camera.fx, 0.0, camera.cx, 0.0, camera.fy, camera.cy, 0.0, 0.0, 1.0};
  impl_->info.publish(message);
  const auto is_connected = [&] {
    for (const ros::Publisher* to : {&impl_->info, &impl_->colour, &impl_->depth}) {
      if (to->getNumSubscribers() == 0) return false;
    }
    if (with_imu && impl_->imu.getNumSubscribers() == 0) return false;
    for (const ros::Subscriber& from : impl_->subscribers) {
      if (from.getNumPublishers() == 0) return false;
    }
    return true;
  };
  for (double waited = 0.0; !is_connected(); waited += kPoll) {
    if (waited > kTimeout) return false;
    ros::WallDuration(kPoll).sleep();
  }
  return true;
}

void RosPeer::PublishImages(Stamp stamp, const cv::Mat& bgr, const cv::Mat& depth) const {
  namespace encodings = sensor_msgs::image_encodings;
  impl_->depth.publish(MessageOf(
      stamp, depth, depth.depth() == CV_32F ? encodings::TYPE_32FC1 : encodings::TYPE_16UC1));
  impl_->colour.publish(MessageOf(stamp, bgr, encodings::BGR8));
}

void RosPeer::PublishImu(Stamp stamp, const Eigen::Vector3d& gyroscope,
                         const Eigen::Vector3d& accelerometer) const {
  sensor_msgs::Imu message;
  message.header.stamp = apps::ToRos(stamp);
  message.angular_velocity.x = gyroscope.x();
  message.angular_velocity.y = gyroscope.y();
  message.angular_velocity.z = gyroscope.z();
  message.linear_acceleration.x = accelerometer.x();
  message.linear_acceleration.y = accelerometer.y();
  message.linear_acceleration.z = accelerometer.z();
  impl_->imu.publish(message);
}

Heard RosPeer::heard() const {
  const std::lock_guard<std::mutex> lock(impl_->mutex);
  return impl_->heard;
}

apps::Answer RosPeer::Call(const std::string& service) {
  std_srvs::Trigger call;
  if (!ros::service::call(service, call)) return {false, "there is no such service"};
  return {call.response.success != 0, call.response.message};
}

apps::Answer RosPeer::Call(const std::string& service, bool value) {
  std_srvs::SetBool call;
  call.request.data = value;
  if (!ros::service::call(service, call)) return {false, "there is no such service"};
  return {call.response.success != 0, call.response.message};
}

void RosPeer::Shutdown(const std::string& node) {
  XmlRpc::XmlRpcValue request, answer, payload;
  request[0] = ros::this_node::getName();
  request[1] = node;
  if (!ros::master::execute("lookupNode", request, answer, payload, false)) return;
  std::string host;
  std::uint32_t port = 0;
  if (!ros::network::splitURI(static_cast<std::string>(payload), host, port)) return;
  XmlRpc::XmlRpcClient client(host.c_str(), static_cast<int>(port));
  request[1] = std::string("the test asks for it");
  client.execute("shutdown", request, answer);
}

}  // namespace highwall::ros_node_test
