#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include <highwall/frontend/input/dataset.h>

#include "input/bag_file.h"
#include "input/ros_image.h"

// Which topics of a bag are read: those that are asked for, and else those that fit by type, name,
// frame and content. Topics are indices in BagFile::topics().
namespace highwall {

struct BagImageTopic {
  std::uint32_t topic = 0;
  RosImageDescription first{};  // of its first image
};

struct BagImageTopics {
  BagImageTopic colour{}, depth{};
  bool is_registered = false;  // by its name or frame, depth is of the view of colour
};

// A topic with both sensors, or one each.
struct BagImuTopics {
  std::uint32_t gyroscope = 0, accelerometer = 0;

  bool IsOne() const { return gyroscope == accelerometer; }
};

// Throws IoError, which names the topics of the bag and their types, if a topic that is asked for
// is none of its images, and if there is no colour or no depth.
BagImageTopics ChooseImages(const BagFile& bag, const BagTopics& wanted);

// Returns nothing if there is no IMU. near: a topic of the camera; an IMU of the same device comes
// first. Throws likewise.
std::optional<BagImuTopics> ChooseImu(const BagFile& bag, const BagTopics& wanted,
                                      std::string_view near);

// Returns " It has /a (sensor_msgs/Image), /b (...)."
std::string ListOfTopics(const BagFile& bag);

// Returns the name of an image topic without that of its transport: "/compressed" and the like.
std::string WithoutTransport(const std::string& topic);

}  // namespace highwall
