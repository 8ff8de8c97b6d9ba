#pragma once

#include <highwall/frontend/input/dataset.h>
#include <highwall/frontend/input/sensor.h>
#include <highwall/frontend/input/sensor_verdict.h>

namespace highwall::apps {

// Returns what the stamps of a recording and a few of its images show about its configuration,
// before any frame is tracked.
SensorVerdict ExamineRecording(const Dataset& dataset, const RgbdSensor& sensor);

}  // namespace highwall::apps
