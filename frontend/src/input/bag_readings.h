#pragma once

#include <cstdint>
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
// headers. Throws IoError if a message is damaged or no reading is left.
ImuRecording ReadBagReadings(const BagFile& bag, const BagImuTopics& topics, bool use_recorded);

// Whether the headers of a topic have no stamps: that of its first message is 0.
bool LacksStamps(const BagFile& bag, std::uint32_t topic);

}  // namespace highwall
