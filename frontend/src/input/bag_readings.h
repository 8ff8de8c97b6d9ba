#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <highwall/factors/imu_buffer.h>
#include <highwall/frontend/input/dataset.h>

#include "input/bag_file.h"
#include "input/bag_topics.h"
#include "input/message_reader.h"
#include "input/ros_messages.h"

namespace highwall {

// Returns the readings of the gyroscope, in their order, each with the accelerometer at its stamp:
// linear between two of its readings, which are less than a tenth of a second apart; without such
// a pair a reading is left out.
std::vector<ImuSample> JoinReadings(std::vector<ImuSample> gyroscope,
                                    std::vector<ImuSample> accelerometer);

// Reads the IMU of a bag. use_recorded: stamps are the times of recording, not those of the
// headers. Readings that are damaged or have no stamp are left out, with a warning. Throws IoError
// if no reading is left.
ImuRecording ReadBagReadings(const BagFile& bag, const BagImuTopics& topics, bool use_recorded);

// Returns the stamp in the header with which a message begins; 0 if it has none.
Stamp HeaderStamp(const BagFile& bag, const BagMessage& message);

// Whether one of the topics has no stamps: those of most of its headers are 0. Messages too short
// for a stamp do not count.
bool LackStamps(const BagFile& bag, std::span<const std::uint32_t> topics);

}  // namespace highwall
