#pragma once

#include <filesystem>

#include <highwall/frontend/input/dataset.h>

namespace [[gnu::visibility("default")]] highwall {

// Whether this is a bag of ROS by its name or, of a folder, by its content: FILE.bag, FILE.db3,
// FILE.mcap, or a folder with files of the last two kinds.
bool IsBag(const std::filesystem::path& path);

// Reads the IMU of a bag, which need not have images. topics: of which those of the IMU count;
// empty ones are guessed. The readings of a gyroscope and an accelerometer of their own are joined
// at the stamps of the gyroscope, between two readings of the accelerometer linearly. Throws
// IoError if the bag has no IMU, which names its topics, or cannot be read.
ImuRecording ReadBagImu(const std::filesystem::path& path, const BagTopics& topics = {});

}  // namespace highwall
