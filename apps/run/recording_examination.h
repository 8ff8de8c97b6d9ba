#pragma once

#include <cstddef>
#include <cstdint>

#include <highwall/frontend/input/dataset.h>
#include <highwall/frontend/input/sensor.h>
#include <highwall/frontend/input/sensor_verdict.h>

namespace highwall::apps {

// Returns what a recording shows about its configuration before any frame is tracked: the stamps of
// all frames, and a few of the images [begin, end).
SensorVerdict ExamineRecording(const Dataset& dataset, const RgbdSensor& sensor,
                               std::size_t begin = 0, std::size_t end = SIZE_MAX);

}  // namespace highwall::apps
