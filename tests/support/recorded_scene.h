#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <opencv2/core.hpp>

#include <highwall/core/camera.h>
#include <highwall/core/pose.h>
#include <highwall/core/stamp.h>

#include "support/bag_messages.h"

// A few images and readings of an IMU as a robot records them with ROS.
namespace highwall::testing {

inline constexpr Stamp kSceneStart = 1'700'000'000'000'000'000;
inline constexpr Stamp kSceneStep = 100'000'000;
inline constexpr int kSceneFrames = 6;

struct RecordedScene {
  Serialization how = Serialization::kRos1;
  std::string colour = "/camera/color/image_raw", depth = "/camera/aligned_depth/image_raw";
  std::string colour_info = "/camera/color/camera_info";  // empty: none
  std::string imu = "/camera/imu";                        // likewise
  std::string colour_frame = "color_optical", depth_frame = "color_optical";
  PinholeCamera camera{
      .width = 64, .height = 48, .fx = 60.0, .fy = 61.0, .cx = 31.0, .cy = 24.0, .k1 = 0.01};
  Stamp recorded_later = 5'000'000;  // than the headers say
  bool has_stamps = true;
};

inline cv::Mat SceneColour(int frame) {
  cv::Mat colour(48, 64, CV_8UC3);
  cv::RNG(static_cast<std::uint64_t>(frame) + 1).fill(colour, cv::RNG::UNIFORM, 0, 256);
  return colour;
}

// [mm] with holes.
inline cv::Mat SceneDepth(int frame) {
  cv::Mat depth(48, 64, CV_16UC1);
  cv::RNG(static_cast<std::uint64_t>(frame) + 100).fill(depth, cv::RNG::UNIFORM, 600, 4000);
  depth.col(frame).setTo(0);
  return depth;
}

inline Stamp SceneStamp(int frame) {
  return kSceneStart + frame * kSceneStep;
}

inline Eigen::Vector3d SceneRate(int reading) {
  return {0.01 * reading, -0.1, 0.2};
}
inline Eigen::Vector3d SceneForce(int reading) {
  return {0.5, 9.7, -0.001 * reading};
}

// Readings of the IMU at 200 Hz from 50 ms before the first image until 50 ms behind the last.
inline constexpr int kSceneReadings = 121;
inline Stamp ReadingStamp(int reading) {
  return kSceneStart - 50'000'000 + reading * Stamp{5'000'000};
}

inline std::vector<WrittenMessage> MessagesOf(const RecordedScene& scene) {
  std::vector<WrittenMessage> messages;
  const auto stamp = [&](Stamp time) { return scene.has_stamps ? time : 0; };
  const auto add = [&](const std::string& topic, const std::string& type, Stamp time,
                       const std::string& bytes) {
    messages.push_back({topic, type, time + scene.recorded_later, bytes});
  };
  if (!scene.colour_info.empty()) {
    add(scene.colour_info, "sensor_msgs/CameraInfo", SceneStamp(0),
        CameraInfoMessage(scene.how, scene.colour_frame, scene.camera));
  }
  for (int i = 0; i < kSceneFrames; ++i) {
    add(scene.colour, "sensor_msgs/Image", SceneStamp(i),
        ImageMessage(scene.how, stamp(SceneStamp(i)), scene.colour_frame, SceneColour(i), "bgr8"));
    add(scene.depth, "sensor_msgs/Image", SceneStamp(i) + 2'000'000,
        ImageMessage(scene.how, stamp(SceneStamp(i) + 2'000'000), scene.depth_frame, SceneDepth(i),
                     "16UC1"));
  }
  if (scene.imu.empty()) return messages;
  for (int i = 0; i < kSceneReadings; ++i) {
    add(scene.imu, "sensor_msgs/Imu", ReadingStamp(i),
        ImuMessage(scene.how, stamp(ReadingStamp(i)), "imu_frame", SceneRate(i), SceneForce(i)));
  }
  return messages;
}

}  // namespace highwall::testing
