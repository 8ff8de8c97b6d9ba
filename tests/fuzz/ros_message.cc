#include "input/ros_messages.h"

#include <opencv2/core.hpp>

#include "fuzz.h"
#include "input/ros_image.h"
#include "support/bag_messages.h"

namespace highwall::fuzz {
namespace {

using testing::Serialization;

constexpr std::size_t kKinds = 6;

void ReadKind(std::size_t kind, const RosImageBytes& image) {
  MessageReader reader(image.path, image.name, image.topic.encoding, image.bytes);
  switch (kind) {
    case 0:
    case 1:
      DescribeRosImage(image);
      DecodeRosColour(image);
      break;
    case 2:
      DecodeRosDepth(image);
      break;
    case 3:
      ReadRosCameraInfo(&reader);
      break;
    case 4:
      ReadRosImu(&reader);
      break;
    default:
      ReadRosTransforms(&reader);
  }
}

}  // namespace

// Input: a byte that selects the kind and the serialization of the message, and the message.
const Target kTarget{
    .file_name = "recording.bag",
    .seeds =
        [] {
          std::vector<std::string> seeds;
          const auto add = [&](std::size_t kind, Serialization how, const std::string& message) {
            const std::size_t serialization = how == Serialization::kRos1 ? 0 : kKinds;
            seeds.push_back(static_cast<char>(kind + serialization) + message);
          };
          const cv::Mat colour(2, 2, CV_8UC3, cv::Scalar(1, 2, 3));
          const cv::Mat depth(2, 2, CV_16UC1, cv::Scalar(1000));
          for (const Serialization how :
               {Serialization::kRos1, Serialization::kCdr, Serialization::kBigEndianCdr}) {
            add(0, how, ImageMessage(how, 1, "c", colour, "rgb8", 2));
            add(1, how, CompressedImageMessage(how, 1, "c", "jpeg", "\xFF\xD8\xFF"));
            add(2, how, ImageMessage(how, 1, "d", depth, "16UC1", 0, true));
            add(3, how, CameraInfoMessage(how, "c", PinholeCamera()));
            add(4, how, ImuMessage(how, 1, "i", {1, 2, 3}, {4, 5, 6}));
            add(5, how, TransformsMessage(how, {{"a", "b", Pose()}, {"b", "c", Pose()}}));
          }
          return seeds;
        },
    .file = nullptr,
    .read =
        [](const std::filesystem::path& path) {
          const std::string text = ReadBytes(path);
          if (text.empty()) return;
          const std::size_t which = static_cast<unsigned char>(text[0]) % (2 * kKinds);
          const std::size_t kind = which % kKinds;
          const BagTopic topic{"/topic",
                               kind == 1 ? "sensor_msgs/CompressedImage" : "sensor_msgs/Image",
                               which < kKinds ? MessageEncoding::kRos1 : MessageEncoding::kCdr, 1};
          const ByteSpan bytes(reinterpret_cast<const std::uint8_t*>(text.data()), text.size());
          ReadKind(kind, {path, "the message", topic, bytes.subspan(1)});
        },
};

}  // namespace highwall::fuzz
