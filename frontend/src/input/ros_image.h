#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include <opencv2/core/mat.hpp>

#include "input/bag_file.h"
#include "input/byte_reader.h"

namespace highwall {

// What an image is, by its encoding.
enum class RosImageKind { kColour, kGrey, kDepth, kOther };

struct RosImageDescription {
  RosImageKind kind = RosImageKind::kOther;
  bool in_metres = false;  // depth; else in 16 bits
  bool is_compressed = false;
  int width = 0, height = 0;  // [px] 0 x 0: compressed
  std::string frame;          // of the header
  std::string encoding;       // for messages
};

// A message of a topic of images.
struct RosImageBytes {
  const std::filesystem::path& path;  // of the bag
  std::string_view name;              // of the message, for errors
  const BagTopic& topic;
  ByteSpan bytes;
};

// Whether the messages of a topic are images: sensor_msgs/Image or CompressedImage.
bool IsRosImage(const BagTopic& topic);

// Describes an image without decoding it. Throws IoError if the message ends early.
RosImageDescription DescribeRosImage(const RosImageBytes& message);

// Returns CV_8UC3 in the order BGR, of grey images too. Throws IoError if the message is damaged or
// its encoding is not known, which the error names with those that are.
cv::Mat DecodeRosColour(const RosImageBytes& message);

// Returns stored values: CV_16UC1, or CV_32FC1 [m] with 0 where nothing was measured. Throws
// likewise. Source of the transport compressedDepth: ROS wiki, "compressed_depth_image_transport",
// https://wiki.ros.org/compressed_depth_image_transport
cv::Mat DecodeRosDepth(const RosImageBytes& message);

}  // namespace highwall
