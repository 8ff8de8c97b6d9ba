#include "input/frame_tree.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <utility>
#include <vector>

#include <highwall/core/error.h>

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

bool IsTransforms(const BagTopic& topic) {
  return topic.type == "tf2_msgs/TFMessage" || topic.type == "tf/tfMessage";
}

bool IsStaticTransform(const BagTopic& topic) {
  return IsTransforms(topic) && topic.name.ends_with("tf_static");
}

// Transforms that need not be fixed.
bool IsMovingTransform(const BagTopic& topic) {
  return IsTransforms(topic) && (topic.name == "tf" || topic.name.ends_with("/tf"));
}

std::vector<RosTransform> TransformsOf(const BagFile& bag, const BagMessage& message) {
  const std::vector<std::uint8_t> bytes = bag.Read(message);
  const std::string name = bag.NameOf(message);
  MessageReader reader(bag.path(), name, bag.topics()[message.topic].encoding, bytes);
  return ReadRosTransforms(&reader);
}

// Returns messages of /tf: groups that follow each other, since each publisher has messages of its
// own, from the whole recording, since a robot that rests at first has no moving frame.
std::vector<const BagMessage*> SomeMovingTransforms(const BagFile& bag) {
  constexpr std::size_t kGroups = 20, kGroup = 25;
  std::vector<const BagMessage*> all;
  for (const BagMessage& message : bag.messages()) {
    const BagTopic& topic = bag.topics()[message.topic];
    if (topic.encoding != MessageEncoding::kOther && IsMovingTransform(topic)) {
      all.push_back(&message);
    }
  }
  if (all.size() <= kGroups * kGroup) return all;
  std::vector<const BagMessage*> some;
  for (std::size_t group = 0; group < kGroups; ++group) {
    const std::size_t begin = group * (all.size() - kGroup) / (kGroups - 1);
    for (std::size_t i = begin; i < begin + kGroup; ++i) some.push_back(all[i]);
  }
  return some;
}

void AddConstantTransforms(const BagFile& bag, FrameTree* tree) {
  constexpr double kSame = 1e-9;  // [m] and of the rotation matrix
  struct Seen {
    Pose first;
    std::size_t times = 0;
    bool is_constant = true;
  };
  std::map<std::pair<std::string, std::string>, Seen> all;  // by frame and child
  for (const BagMessage* const message : SomeMovingTransforms(bag)) {
    try {
      for (const RosTransform& transform : TransformsOf(bag, *message)) {
        Seen& seen = all[{transform.frame, transform.child}];
        if (seen.times++ == 0) seen.first = transform.pose;
        seen.is_constant &=
            (transform.pose.Matrix() - seen.first.Matrix()).cwiseAbs().maxCoeff() <= kSame;
      }
    } catch (const IoError&) {  // of transforms that need not be there
    }
  }
  for (const auto& [frames, seen] : all) {
    if (seen.times > 1 && seen.is_constant) {
      tree->AddConstant(frames.first, frames.second, seen.first);
    }
  }
}

}  // namespace

void FrameTree::Add(const std::string& a, const std::string& b, const Pose& T) {
  for (Neighbours* const tree : {&fixed_, &all_}) {
    (*tree)[a].insert_or_assign(b, T);
    (*tree)[b].insert_or_assign(a, T.Inverse());
  }
}

void FrameTree::AddConstant(const std::string& a, const std::string& b, const Pose& T) {
  all_[a].emplace(b, T);
  all_[b].emplace(a, T.Inverse());
}

std::optional<Pose> FrameTree::Find(const std::string& a, const std::string& b) const {
  const std::optional<Pose> fixed = FindIn(fixed_, a, b);
  return fixed ? fixed : FindIn(all_, a, b);
}

std::optional<Pose> FrameTree::FindIn(const Neighbours& tree, const std::string& a,
                                      const std::string& b) {
  if (a == b) return Pose();
  std::map<std::string, Pose> found{{a, Pose()}};  // T_ax by x
  std::deque<std::string> next{a};
  while (!next.empty()) {
    const std::string at = next.front();
    next.pop_front();
    const auto neighbours = tree.find(at);
    if (neighbours == tree.end()) continue;
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
    if (is_stream) {
      const std::vector<std::uint8_t> bytes = bag.Read(message);
      const std::string name = bag.NameOf(message);
      MessageReader reader(bag.path(), name, topic.encoding, bytes);
      const std::optional<Pose> T = ReadRosTransform(&reader);
      const std::string reference = "reference" + topic.name.substr(topic.name.rfind('/'));
      if (T) tree.Add(StreamOf(topic.name), reference, *T);
      continue;
    }
    for (const RosTransform& transform : TransformsOf(bag, message)) {
      tree.Add(transform.frame, transform.child, transform.pose);
    }
  }
  AddConstantTransforms(bag, &tree);
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
