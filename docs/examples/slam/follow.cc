// Tracks a recording and writes its trajectory: follow FOLDER
#include "follow.h"

#include <cstdio>

#include <highwall/frontend/input/sensor.h>

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: follow FOLDER, a recording with its calibration.yaml\n");
    return 1;
  }
  const std::filesystem::path folder = argv[1];
  const auto calibration = highwall::ReadSensor(folder / "calibration.yaml");
  highwall::WriteTumTrajectory("trajectory.txt", Follow(folder, calibration.sensor));
}
