#pragma once

#include <string>

#include "ros/camera_stream.h"
#include "ros/ros_link.h"
#include "ros/ros_types.h"
#include "run/slam_arguments.h"

namespace highwall::apps {

// Options of the node; those of the run have the names of the switches of `highwall slam`.
struct NodeOptions {
  SlamArguments slam;              // out: the folder of the first run
  std::string sensor = "generic";  // name of the SensorProfile of a camera without a config
  CameraStreamOptions camera;
  double imu_lead = 0.05;  // [s]: CameraStreamOptions::imu_lead with an IMU
  RosLinkOptions link;
  double publish_period = 1.0;  // [s] RunPublisherOptions::period
};

// Reads the parameters: docs/ros.md. Throws InvalidArgument for an unknown one, suggesting a
// similar one, and for a value that is not valid; IoError for a settings file.
NodeOptions ReadNodeOptions(const Parameters& parameters);

}  // namespace highwall::apps
