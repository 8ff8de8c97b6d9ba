#include "input/frame_tree.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <vector>

#include "input/message_reader.h"
#include "input/ros_messages.h"

namespace highwall {
namespace {

// In a bag of the SDK of RealSense, T of /device_0/sensor_1/Color_0/tf/0 takes points from the
// stream that is the reference 0 of the extrinsics to this one.
// Source: librealsense, "Sample Data" and its recorder: extrinsics are fetched from the reference.
constexpr std::string_view kStreamTransform = "/tf/";

// Returns the name of the stream, "/device_0/sensor_1/Color_0"; empty for other topics.
std::string StreamOf(const std::string& topic) {
  if (!topic.starts_with("/device_")) return "";
  std::size_t end = 0;
  for (int part = 0; part < 3; ++part) {
    end = topic.find('/', end + 1);
    if (end == std::string::npos) return "";
  }
  return topic.substr(0, end);
}

bool IsStreamTransform(const BagTopic& topic) {
  const std::string stream = StreamOf(topic.name);
  return topic.type == "geometry_msgs/Transform" && !stream.empty() &&
         std::string_view(topic.name).substr(stream.size()).starts_with(kStreamTransform);
}

bool IsStaticTransform(const BagTopic& topic) {
  return (topic.type == "tf2_msgs/TFMessage" || topic.type == "tf/tfMessage") &&
         topic.name.ends_with("tf_static");
}

}  // namespace

void FrameTree::Add(const std::string& a, const std::string& b, const Pose& T) {
  neighbours_[a].insert_or_assign(b, T);
  neighbours_[b].insert_or_assign(a, T.Inverse());
}

std::optional<Pose> FrameTree::Find(const std::string& a, const std::string& b) const {
  if (a == b) return Pose();
  std::map<std::string, Pose> found{{a, Pose()}};  // T_ax by x
  std::deque<std::string> next{a};
  while (!next.empty()) {
    const std::string at = next.front();
    next.pop_front();
    const auto neighbours = neighbours_.find(at);
    if (neighbours == neighbours_.end()) continue;
    for (const auto& [name, T] : neighbours->second) {
      const Pose T_a = found.at(at) * T;
      if (name == b) return T_a;
      if (found.emplace(name, T_a).second) next.push_back(name);
    }
  }
  return std::nullopt;
}

FrameTree ReadFrameTree(const BagFile& bag) {
  FrameTree tree;
  for (const BagMessage& message : bag.messages()) {
    const BagTopic& topic = bag.topics()[message.topic];
    const bool is_stream = IsStreamTransform(topic);
    if (topic.encoding == MessageEncoding::kOther) continue;
    if (!is_stream && !IsStaticTransform(topic)) continue;
    const std::vector<std::uint8_t> bytes = bag.Read(message);
    const std::string name = bag.NameOf(message);
    MessageReader reader(bag.path(), name, topic.encoding, bytes);
    if (is_stream) {
      const std::optional<Pose> T = ReadRosTransform(&reader);
      const std::string reference = "reference" + topic.name.substr(topic.name.rfind('/'));
      if (T) tree.Add(StreamOf(topic.name), reference, *T);
      continue;
    }
    for (const RosTransform& transform : ReadRosTransforms(&reader)) {
      tree.Add(transform.frame, transform.child, transform.pose);
    }
  }
  return tree;
}

std::string FrameOf(const BagFile& bag, const std::string& topic, const std::string& frame) {
  const std::string stream = StreamOf(topic);
  const bool has_transform = std::ranges::any_of(bag.topics(), [&](const BagTopic& other) {
    return IsStreamTransform(other) && StreamOf(other.name) == stream;
  });
  return has_transform ? stream : frame;
}

}  // namespace highwall
