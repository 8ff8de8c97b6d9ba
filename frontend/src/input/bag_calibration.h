#pragma once

#include <optional>
#include <string>
#include <vector>

#include <opencv2/core/types.hpp>

#include <highwall/frontend/input/sensor.h>

#include "input/bag_file.h"
#include "input/bag_topics.h"

namespace highwall {

// What a bag states of its sensors.
struct BagCalibration {
  // Empty without a camera_info of the colour images. The rate of the IMU is not stated.
  std::optional<SensorCalibration> calibration{};
  bool is_registered = false;  // for certain; depth that is registered here is not
  std::vector<std::string> warnings{};
};

// colour, depth: sizes of the images. Cameras are those of the topics camera_info beside the
// images, or with their frame; extrinsics those of /tf_static or of the streams of a RealSense.
// Throws IoError if a message is damaged or a camera is none.
BagCalibration ReadBagCalibration(const BagFile& bag, const BagImageTopics& images,
                                  const std::optional<BagImuTopics>& imu, const cv::Size& colour,
                                  const cv::Size& depth);

// Stored value of depth for one metre: 1 for images in metres; else 1000, unless the SDK of
// RealSense states it.
double DepthFactorOf(const BagFile& bag, const BagImageTopic& depth);

}  // namespace highwall
