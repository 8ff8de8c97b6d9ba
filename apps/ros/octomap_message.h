#pragma once

#include <ros/message_traits.h>
#include <ros/serialization.h>
#include <std_msgs/Header.h>

#include <cstdint>
#include <string>
#include <vector>

// octomap_msgs/Octomap, which Debian does not have: the same name, fields and checksum.
namespace highwall::apps {

struct OctomapMessage {
  std_msgs::Header header;
  std::uint8_t binary = 1;    // only free or occupied
  std::string id = "OcTree";  // the class of the tree
  double resolution = 0.0;    // [m]
  std::vector<std::int8_t> data;
};

}  // namespace highwall::apps

namespace ros {
namespace message_traits {

template <>
struct IsMessage<highwall::apps::OctomapMessage> : TrueType {};
template <>
struct IsMessage<const highwall::apps::OctomapMessage> : TrueType {};
template <>
struct HasHeader<highwall::apps::OctomapMessage> : TrueType {};
template <>
struct HasHeader<const highwall::apps::OctomapMessage> : TrueType {};

template <>
struct MD5Sum<highwall::apps::OctomapMessage> {
  static const char* value() { return "9a45536b45c5e409cd49f04bb2d9999f"; }
  static const char* value(const highwall::apps::OctomapMessage&) { return value(); }
};

template <>
struct DataType<highwall::apps::OctomapMessage> {
  static const char* value() { return "octomap_msgs/Octomap"; }
  static const char* value(const highwall::apps::OctomapMessage&) { return value(); }
};

template <>
struct Definition<highwall::apps::OctomapMessage> {
  static const char* value() {
    return "Header header\n"
           "bool binary\n"
           "string id\n"
           "float64 resolution\n"
           "int8[] data\n"
           "================================================================================\n"
           "MSG: std_msgs/Header\n"
           "uint32 seq\n"
           "time stamp\n"
           "string frame_id\n";
  }
  static const char* value(const highwall::apps::OctomapMessage&) { return value(); }
};

}  // namespace message_traits

namespace serialization {

template <>
struct Serializer<highwall::apps::OctomapMessage> {
  template <typename Stream, typename T>
  inline static void allInOne(Stream& stream, T message) {
    stream.next(message.header);
    stream.next(message.binary);
    stream.next(message.id);
    stream.next(message.resolution);
    stream.next(message.data);
  }
  ROS_DECLARE_ALLINONE_SERIALIZER
};

}  // namespace serialization
}  // namespace ros
