// SLAM over a TUM sequence with the points of a network of your own:
//   network_points tum1 DATASET NETWORK.onnx TRAJECTORY.txt
#include "network_points.h"

#include <cstdio>
#include <exception>
#include <memory>
#include <optional>

#include <highwall/core/trajectory.h>
#include <highwall/frontend/input/tum_dataset.h>
#include <highwall/frontend/system/slam_system.h>

int main(int argc, char** argv) try {
  const auto sensor = argc == 5 ? highwall::SensorPreset(argv[1]) : std::nullopt;
  if (!sensor) {
    std::fprintf(stderr,
                 "usage: network_points tum1|tum2|tum3 DATASET NETWORK.onnx TRAJECTORY.txt\n");
    return 1;
  }
  const auto points = std::make_shared<NetworkPoints>(argv[3]);
  highwall::SlamSystem slam(*sensor, {}, {.points = points});
  const highwall::TumDataset dataset(argv[2], *sensor);
  for (std::size_t i = 0; i < dataset.size(); ++i) {
    if (const auto image = dataset.Load(i)) slam.Track(*image);
  }
  slam.Finish();
  highwall::WriteTumTrajectory(argv[4], slam.trajectory());
  std::printf("%zu of %zu frames, %zu points in the map\n", slam.trajectory().size(),
              dataset.size(), slam.map().num<highwall::MapPoint>());
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "network_points: %s\n", error.what());
  return 3;
}
