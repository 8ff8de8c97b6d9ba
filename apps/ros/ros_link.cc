#include "ros/ros_link.h"

#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <nav_msgs/Odometry.h>
#include <ros/callback_queue.h>
#include <ros/ros.h>
#include <std_srvs/SetBool.h>
#include <std_srvs/Trigger.h>
#include <tf2_ros/buffer.h>
#include <tf2_ros/transform_broadcaster.h>
#include <tf2_ros/transform_listener.h>

#include <array>
#include <charconv>
#include <exception>
#include <memory>
#include <optional>
#include <utility>

#include <highwall/core/error.h>

#include "ros/conversions.h"

namespace highwall::apps {
namespace {

// Messages that may wait for the thread that receives them, which only hands them on.
constexpr std::uint32_t kImages = 60;
constexpr std::uint32_t kReadings = 4000;
constexpr std::uint32_t kPublished = 100;
constexpr double kTfSeconds = 30.0;  // that the buffer of transforms holds

// Adds the values below a name of the parameter server.
void AddParameters(const std::string& path, XmlRpc::XmlRpcValue& value, Parameters* parameters) {
  using Value = XmlRpc::XmlRpcValue;
  switch (value.getType()) {
    case Value::TypeStruct:
      for (auto& [name, member] : value) {
        AddParameters(path.empty() ? name : path + "." + name, member, parameters);
      }
      return;
    case Value::TypeBoolean:
      (*parameters)[path] = static_cast<bool>(value) ? "true" : "false";
      return;
    case Value::TypeInt:
      (*parameters)[path] = std::to_string(static_cast<int>(value));
      return;
    case Value::TypeString:
      (*parameters)[path] = static_cast<std::string>(value);
      return;
    case Value::TypeDouble: {
      std::array<char, 32> text{};
      const auto end = std::to_chars(text.begin(), text.end(), static_cast<double>(value)).ptr;
      (*parameters)[path] = std::string(text.begin(), end);
      return;
    }
    default:
      throw InvalidArgument("the parameter " + path + " is neither a number nor a text");
  }
}

}  // namespace

struct RosLink::Impl {
  // Their threads end first.
  ~Impl() {
    Stop();
    ros::shutdown();
  }
  void Stop() {
    for (ros::Subscriber& subscriber : subscribers) subscriber.shutdown();
    for (ros::ServiceServer& server : servers) server.shutdown();
    receiving.reset();
    serving.reset();
  }

  template <class Message, class Handle>
  void Subscribe(const char* topic, std::uint32_t queue, Handle handle) {
    const boost::function<void(const boost::shared_ptr<const Message>&)> checked =
        [this, handle](const boost::shared_ptr<const Message>& message) {
          try {
            handle(*message);
          } catch (const std::exception& error) {
            listener->OnProblem(error.what());
          }
        };
    subscribers.push_back(node.subscribe<Message>(topic, queue, checked, ros::VoidConstPtr(),
                                                  ros::TransportHints().tcpNoDelay()));
  }
  void SubscribeToCamera();
  void SubscribeToSensors();
  void AdvertiseTopics();
  void AdvertiseServices();

  std_msgs::Header Header(Stamp stamp, const std::string& frame) const {
    std_msgs::Header header;
    header.stamp = ToRos(stamp);
    header.frame_id = frame;
    return header;
  }

  RosLinkOptions options;
  RosListener* listener = nullptr;
  bool receives_sensors = false;
  ros::NodeHandle node, own{"~"};
  ros::NodeHandle services{"~"};
  ros::CallbackQueue requests;  // of the services, which may take long
  std::vector<ros::Subscriber> subscribers;
  std::vector<ros::ServiceServer> servers;
  ros::Publisher pose, odometry, state, path, cloud, octree, grid;
  tf2_ros::TransformBroadcaster broadcaster;
  tf2_ros::Buffer transforms{ros::Duration(kTfSeconds)};
  std::unique_ptr<tf2_ros::TransformListener> transform_listener;
  std::unique_ptr<ros::AsyncSpinner> receiving, serving;
};

void RosLink::Impl::SubscribeToCamera() {
  Subscribe<sensor_msgs::CameraInfo>("rgb/camera_info", kImages,
                                     [this](const sensor_msgs::CameraInfo& message) {
                                       listener->OnCamera(CameraOf(message, options.rectified));
                                     });
}

void RosLink::Impl::SubscribeToSensors() {
  receives_sensors = true;
  Subscribe<sensor_msgs::Image>("rgb/image", kImages, [this](const sensor_msgs::Image& message) {
    listener->OnColour(FromRos(message.header.stamp), ColourOf(message));
  });
  Subscribe<sensor_msgs::Image>("depth/image", kImages, [this](const sensor_msgs::Image& message) {
    listener->OnDepth(FromRos(message.header.stamp), DepthOf(message));
  });
  if (!options.imu) return;
  Subscribe<sensor_msgs::Imu>("imu", kReadings, [this](const sensor_msgs::Imu& message) {
    const auto& w = message.angular_velocity;
    const auto& a = message.linear_acceleration;
    listener->OnImu(FromRos(message.header.stamp), {w.x, w.y, w.z}, {a.x, a.y, a.z});
  });
}

void RosLink::Impl::AdvertiseTopics() {
  pose = own.advertise<geometry_msgs::PoseWithCovarianceStamped>("pose", kPublished);
  odometry = own.advertise<nav_msgs::Odometry>("odometry", kPublished);
  state = node.advertise<diagnostic_msgs::DiagnosticArray>("/diagnostics", kPublished);
  path = own.advertise<nav_msgs::Path>("path", 1, true);
  cloud = own.advertise<sensor_msgs::PointCloud2>("cloud", 1, true);
  octree = own.advertise<OctomapMessage>("octomap", 1, true);
  grid = own.advertise<nav_msgs::OccupancyGrid>("grid", 1, true);
}

void RosLink::Impl::AdvertiseServices() {
  using Trigger = std_srvs::Trigger;
  using SetBool = std_srvs::SetBool;
  const auto answer = [](const Answer& given, auto& response) {
    response.success = given.success;
    response.message = given.message;
    return true;
  };
  services.setCallbackQueue(&requests);
  const boost::function<bool(Trigger::Request&, Trigger::Response&)> save =
      [this, answer](Trigger::Request&, Trigger::Response& response) {
        return answer(listener->OnSave(), response);
      };
  const boost::function<bool(Trigger::Request&, Trigger::Response&)> reset =
      [this, answer](Trigger::Request&, Trigger::Response& response) {
        return answer(listener->OnReset(), response);
      };
  const boost::function<bool(SetBool::Request&, SetBool::Response&)> localize =
      [this, answer](SetBool::Request& request, SetBool::Response& response) {
        return answer(listener->OnLocalize(request.data != 0), response);
      };
  servers.push_back(services.advertiseService("save", save));
  servers.push_back(services.advertiseService("reset", reset));
  servers.push_back(services.advertiseService("localize", localize));
}

void RosLink::Init(int& argc, char** argv) {
  ros::init(argc, argv, "highwall", ros::init_options::NoSigintHandler);
}

RosLink::RosLink() {
  if (!ros::master::check()) {
    throw InvalidArgument("there is no ROS master at " + ros::master::getURI() +
                          ": start roscore, or set ROS_MASTER_URI");
  }
  impl_ = std::make_unique<Impl>();
}

RosLink::~RosLink() = default;

Parameters RosLink::parameters() const {
  Parameters parameters;
  XmlRpc::XmlRpcValue all;
  if (ros::param::get(impl_->own.getNamespace(), all)) AddParameters("", all, &parameters);
  return parameters;
}

bool RosLink::ok() const {
  return ros::ok();
}

void RosLink::Start(const RosLinkOptions& options, RosListener& listener) {
  impl_->options = options;
  impl_->listener = &listener;
  impl_->AdvertiseTopics();
  impl_->AdvertiseServices();
  if (!options.frames.base.empty()) {
    impl_->transform_listener = std::make_unique<tf2_ros::TransformListener>(impl_->transforms);
  }
  impl_->SubscribeToCamera();
  impl_->receiving = std::make_unique<ros::AsyncSpinner>(1);
  impl_->receiving->start();
  impl_->serving = std::make_unique<ros::AsyncSpinner>(1, &impl_->requests);
  impl_->serving->start();
}

void RosLink::Receive() {
  if (!impl_->receives_sensors) impl_->SubscribeToSensors();
}

void RosLink::Stop() {
  impl_->Stop();
}

std::optional<Pose> RosLink::T_BC(const std::string& image_frame, double seconds) const {
  const std::string& base = impl_->options.frames.base;
  if (base.empty() || base == image_frame) return Pose();
  try {
    return FromRos(
        impl_->transforms.lookupTransform(base, image_frame, ros::Time(0), ros::Duration(seconds))
            .transform);
  } catch (const tf2::TransformException&) {
    return std::nullopt;
  }
}

void RosLink::PublishTransforms(Stamp stamp, const std::string& base, const Pose& T_WO,
                                const Pose& T_OB) {
  const RosFrames& frames = impl_->options.frames;
  std::vector<geometry_msgs::TransformStamped> both(2);
  both[0].header = impl_->Header(stamp, frames.map);
  both[0].child_frame_id = frames.odom;
  both[0].transform = ToRosTransform(T_WO);
  both[1].header = impl_->Header(stamp, frames.odom);
  both[1].child_frame_id = base;
  both[1].transform = ToRosTransform(T_OB);
  impl_->broadcaster.sendTransform(both);
}

void RosLink::PublishPose(Stamp stamp, const UncertainPose& T_WB) {
  geometry_msgs::PoseWithCovarianceStamped message;
  message.header = impl_->Header(stamp, impl_->options.frames.map);
  message.pose = ToRos(T_WB);
  impl_->pose.publish(message);
}

void RosLink::PublishOdometry(Stamp stamp, const std::string& base, const UncertainPose& T_OB,
                              const Twist& twist) {
  nav_msgs::Odometry message;
  message.header = impl_->Header(stamp, impl_->options.frames.odom);
  message.child_frame_id = base;
  message.pose = ToRos(T_OB);
  message.twist = ToRos(twist);
  impl_->odometry.publish(message);
}

void RosLink::PublishState(Stamp stamp, const StateReport& state) {
  impl_->state.publish(ToRos(state, impl_->Header(stamp, "")));
}

void RosLink::PublishPath(Stamp stamp, const Trajectory& T_WB) {
  impl_->path.publish(ToRos(T_WB, impl_->Header(stamp, impl_->options.frames.map)));
}

void RosLink::PublishCloud(Stamp stamp, const std::vector<ColouredPoint>& points) {
  impl_->cloud.publish(ToRos(points, impl_->Header(stamp, impl_->options.frames.map)));
}

void RosLink::PublishOctree(Stamp stamp, const OctreeMessage& octree) {
  impl_->octree.publish(ToRos(octree, impl_->Header(stamp, impl_->options.frames.map)));
}

void RosLink::PublishGrid(Stamp stamp, const NavigationGrid& grid) {
  impl_->grid.publish(ToRos(grid, impl_->Header(stamp, impl_->options.frames.map)));
}

}  // namespace highwall::apps
