#pragma once

#include <string>

#include "run/slam_arguments.h"

namespace highwall::apps {

// Command-line arguments of `highwall live`.
struct LiveArguments {
  SlamArguments slam;    // live is set
  std::string camera;    // KIND or KIND:DEVICE
  std::string record;    // folder; empty: nothing is recorded
  double seconds = 0.0;  // of the run; 0: until it is stopped
  bool list = false;     // the cameras, and exit
};

// As AddSlamOptions(); CheckArguments() is for its part that is shared.
void AddLiveOptions(CLI::App* command, LiveArguments* arguments);

// A kind of cameras and the device of that kind; empty: the first.
struct CameraChoice {
  std::string kind, device;
};
CameraChoice ReadCameraChoice(const std::string& choice);

}  // namespace highwall::apps
