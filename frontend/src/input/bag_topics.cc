#include "input/bag_topics.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <initializer_list>
#include <vector>

#include <highwall/core/error.h>

#include "input/bag_first_message.h"

namespace highwall {
namespace {

std::string LowerCase(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

bool HasOneOf(const std::string& text, std::initializer_list<std::string_view> words) {
  return std::ranges::any_of(
      words, [&](std::string_view word) { return text.find(word) != std::string::npos; });
}

bool IsImu(const BagTopic& topic) {
  return topic.type == "sensor_msgs/Imu";
}

[[noreturn]] void RefuseTopics(const BagFile& bag, const std::string& what) {
  throw IoError(bag.path(), what + ListOfTopics(bag));
}

// Returns the topic of this name with messages. what: "images", for errors.
template <class IsOfKind>
std::uint32_t TopicNamed(const BagFile& bag, const std::string& name, const IsOfKind& is_of_kind,
                         const char* what) {
  const std::vector<BagTopic>& topics = bag.topics();
  for (std::uint32_t i = 0; i < topics.size(); ++i) {
    if (topics[i].name == name && topics[i].messages > 0 && is_of_kind(topics[i])) return i;
  }
  const bool exists = std::ranges::find(topics, name, &BagTopic::name) != topics.end();
  RefuseTopics(bag, exists ? "its topic " + name + " holds no " + what : "has no topic " + name);
}

// Describes the first image of a topic that is not damaged.
BagImageTopic DescribeImages(const BagFile& bag, std::uint32_t topic) {
  return ReadFirstMessage(bag, topic, [&](const BagMessage& message) -> BagImageTopic {
    const std::vector<std::uint8_t> bytes = bag.Read(message);
    const std::string name = bag.NameOf(message);
    return {topic, DescribeRosImage({bag.path(), name, bag.topics()[topic], bytes})};
  });
}

std::vector<BagImageTopic> ImagesIn(const BagFile& bag) {
  std::vector<BagImageTopic> images;
  for (std::uint32_t i = 0; i < bag.topics().size(); ++i) {
    const BagTopic& topic = bag.topics()[i];
    if (!IsRosImage(topic) || topic.messages == 0) continue;
    try {
      images.push_back(DescribeImages(bag, i));
    } catch (const IoError&) {  // its images are damaged, or of no known serialization
    }
  }
  return images;
}

// Returns the part of an image topic that names the camera: "/front" of "/front/color/image_raw";
// empty if it names none.
std::string DeviceOf(const std::string& topic) {
  constexpr std::string_view kOfSdk = "/device_";  // of RealSense: "/device_0/sensor_1/Color_0/..."
  if (topic.starts_with(kOfSdk)) return topic.substr(0, topic.find('/', kOfSdk.size()));
  std::string name = WithoutTransport(topic);
  for (int part = 0; part < 2; ++part) name.resize(std::min(name.rfind('/'), name.size()));
  return name;
}

bool IsInOneFrame(const BagImageTopic& a, const BagImageTopic& b) {
  // The frames of the SDK of RealSense are numbers, all 0.
  return !a.first.frame.empty() && a.first.frame != "0" && a.first.frame == b.first.frame;
}

// Whether their topics name two cameras.
bool AreOfTwoDevices(const BagFile& bag, const BagImageTopic& a, const BagImageTopic& b) {
  const std::string of_a = DeviceOf(bag.topics()[a.topic].name),
                    of_b = DeviceOf(bag.topics()[b.topic].name);
  return !of_a.empty() && !of_b.empty() && of_a != of_b && !IsInOneFrame(a, b);
}

// Returns the images of an encoding that is not read, for errors: " that are read (/a has
// bayer_grbg8)".
std::string UnreadImages(const BagFile& bag, const std::vector<BagImageTopic>& images) {
  std::string list;
  for (const BagImageTopic& image : images) {
    if (image.first.kind != RosImageKind::kOther) continue;
    list += (list.empty() ? "" : ", ") + bag.topics()[image.topic].name + " has " +
            image.first.encoding;
  }
  return list.empty() ? "" : " that are read (" + list + ")";
}

// Whether depth is of the view of colour: by the name that drivers give it, or by its frame.
bool IsRegistered(const BagFile& bag, const BagImageTopic& colour, const BagImageTopic& depth) {
  const std::string name = LowerCase(bag.topics()[depth.topic].name);
  if (HasOneOf(name, {"aligned", "registered", "depth_to_color", "depth_to_rgb"}) &&
      !HasOneOf(name, {"unaligned", "unregistered"})) {
    return !AreOfTwoDevices(bag, colour, depth);
  }
  const RosImageDescription &a = colour.first, &b = depth.first;
  const bool one_size =
      a.is_compressed || b.is_compressed || (a.width == b.width && a.height == b.height);
  return one_size && IsInOneFrame(colour, depth);
}

// A larger value fits better.
int FitOfColour(const BagFile& bag, const BagImageTopic& image) {
  const std::string name = LowerCase(bag.topics()[image.topic].name);
  int fit = image.first.kind == RosImageKind::kColour ? 8 : 0;
  if (HasOneOf(name, {"color", "colour", "rgb"})) fit += 4;
  if (HasOneOf(name, {"infra", "/ir/", "/ir_", "fisheye", "confidence", "label", "mask", "debug",
                      "depth", "right"})) {
    fit -= 6;
  }
  if (HasOneOf(name, {"rect"})) fit -= 1;  // as recorded, rather
  return 2 * fit + (image.first.is_compressed ? 0 : 1);
}

int FitOfDepth(const BagFile& bag, const BagImageTopic& colour, const BagImageTopic& image) {
  const std::string name = LowerCase(bag.topics()[image.topic].name);
  int fit = IsRegistered(bag, colour, image) ? 8 : 0;
  if (AreOfTwoDevices(bag, colour, image)) fit -= 16;
  if (HasOneOf(name, {"depth", "disparity", "stereo"})) fit += 4;
  if (HasOneOf(name, {"confidence", "infra", "/ir/", "/ir_", "amplitude"})) fit -= 8;
  return 2 * fit + (image.first.is_compressed ? 0 : 1);
}

// Returns the image topic of the best fit; of several the one with most messages, then the first.
template <class Fit>
const BagImageTopic* BestOf(const BagFile& bag, const std::vector<BagImageTopic>& images,
                            bool is_depth, const Fit& fit) {
  const BagImageTopic* best = nullptr;
  const auto value = [&](const BagImageTopic& image) {
    return std::pair(fit(image), bag.topics()[image.topic].messages);
  };
  for (const BagImageTopic& image : images) {
    const bool fits = is_depth ? image.first.kind == RosImageKind::kDepth
                               : image.first.kind == RosImageKind::kColour ||
                                     image.first.kind == RosImageKind::kGrey;
    if (fits && (best == nullptr || value(image) > value(*best))) best = &image;
  }
  return best;
}

// The number of leading parts that two topics share.
std::size_t SharedParts(std::string_view a, std::string_view b) {
  std::size_t parts = 0;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()) && a[i] == b[i]; ++i) {
    if (a[i] == '/') ++parts;
  }
  return parts;
}

// Returns the topic of the IMU of the best fit among those that `fits` accepts.
template <class Fits>
std::optional<std::uint32_t> BestImu(const BagFile& bag, std::string_view near, const Fits& fits) {
  std::optional<std::uint32_t> best;
  const auto value = [&](std::uint32_t i) {
    return std::pair(SharedParts(bag.topics()[i].name, near), bag.topics()[i].messages);
  };
  for (std::uint32_t i = 0; i < bag.topics().size(); ++i) {
    const BagTopic& topic = bag.topics()[i];
    if (!IsImu(topic) || topic.messages == 0 || !fits(LowerCase(topic.name))) continue;
    if (!best || value(i) > value(*best)) best = i;
  }
  return best;
}

}  // namespace

BagImageTopics ChooseImages(const BagFile& bag, const BagTopics& wanted) {
  if (bag.messages().empty()) throw IoError(bag.path(), "holds no message");
  const std::vector<BagImageTopic> images = ImagesIn(bag);
  BagImageTopics chosen;
  if (!wanted.colour.empty()) {
    chosen.colour = DescribeImages(bag, TopicNamed(bag, wanted.colour, IsRosImage, "images"));
  } else {
    const BagImageTopic* const best = BestOf(
        bag, images, false, [&](const BagImageTopic& image) { return FitOfColour(bag, image); });
    if (best == nullptr) RefuseTopics(bag, "holds no colour images" + UnreadImages(bag, images));
    chosen.colour = *best;
  }
  if (!wanted.depth.empty()) {
    chosen.depth = DescribeImages(bag, TopicNamed(bag, wanted.depth, IsRosImage, "images"));
  } else {
    const BagImageTopic* const best = BestOf(bag, images, true, [&](const BagImageTopic& image) {
      return FitOfDepth(bag, chosen.colour, image);
    });
    if (best == nullptr) {
      RefuseTopics(bag,
                   "holds no depth images in 16UC1, mono16 or 32FC1" + UnreadImages(bag, images));
    }
    chosen.depth = *best;
  }
  chosen.is_registered = IsRegistered(bag, chosen.colour, chosen.depth);
  return chosen;
}

std::optional<BagImuTopics> ChooseImu(const BagFile& bag, const BagTopics& wanted,
                                      std::string_view near) {
  const auto named = [&](const std::string& name) {
    return TopicNamed(bag, name, IsImu, "readings of an IMU");
  };
  if (!wanted.imu.empty()) {
    const std::uint32_t topic = named(wanted.imu);
    return BagImuTopics{topic, topic};
  }
  if (!wanted.gyroscope.empty()) {
    return BagImuTopics{named(wanted.gyroscope), named(wanted.accelerometer)};
  }
  const auto is_gyroscope = [](const std::string& name) { return HasOneOf(name, {"gyro"}); };
  const auto is_accelerometer = [](const std::string& name) { return HasOneOf(name, {"accel"}); };
  const auto whole = BestImu(bag, near, [&](const std::string& name) {
    return !is_gyroscope(name) && !is_accelerometer(name);
  });
  const auto gyroscope = BestImu(bag, near, is_gyroscope);
  const auto accelerometer = BestImu(bag, near, is_accelerometer);
  const auto nearness = [&](std::uint32_t topic) {
    return SharedParts(bag.topics()[topic].name, near);
  };
  const bool has_pair = gyroscope && accelerometer;
  // Of the camera's own device rather than of the vehicle.
  if (whole && !(has_pair && nearness(*gyroscope) > nearness(*whole))) {
    return BagImuTopics{*whole, *whole};
  }
  if (!has_pair) return std::nullopt;
  return BagImuTopics{*gyroscope, *accelerometer};
}

std::string ListOfTopics(const BagFile& bag) {
  constexpr std::size_t kMost = 30;
  std::string list;
  std::size_t count = 0;
  for (const BagTopic& topic : bag.topics()) {
    if (++count > kMost) break;
    list += (list.empty() ? "; it has " : ", ") + topic.name + " (" + topic.type + ")";
  }
  if (count > kMost) list += " and more";
  return list.empty() ? "; it has no topics" : list;
}

std::string WithoutTransport(const std::string& topic) {
  for (const std::string_view transport : {"/compressed", "/compressedDepth"}) {
    if (topic.ends_with(transport)) return topic.substr(0, topic.size() - transport.size());
  }
  return topic;
}

}  // namespace highwall
