#pragma once

#include <filesystem>

#include <highwall/core/trajectory.h>
#include <highwall/frontend/input/open_dataset.h>
#include <highwall/frontend/system/slam_system.h>

// Returns T_WC of the frames of a recording that were tracked. None is dropped, however long a
// frame takes. Throws IoError where the folder holds no recording that Highwall reads.
inline highwall::Trajectory Follow(const std::filesystem::path& folder,
                                   const highwall::RgbdSensor& sensor) {
  const auto recording = highwall::OpenDataset(folder, sensor);
  highwall::SlamSystem slam(sensor);
  for (std::size_t i = 0; i < recording->size(); ++i) {
    if (const auto image = recording->Load(i)) slam.Track(*image);
  }
  slam.Finish();
  return slam.trajectory();
}
