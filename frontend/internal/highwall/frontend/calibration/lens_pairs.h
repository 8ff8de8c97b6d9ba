#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include <highwall/frontend/input/dataset.h>
#include <highwall/frontend/input/sensor.h>
#include <highwall/frontend/input/sensor_verdict.h>

namespace [[gnu::visibility("default")]] highwall {

// Tests the lens by eight pairs of the images [begin, end) of a recording, without a map: their
// points are matched by descriptors and epipolar geometry alone, which holds for any lens, so that
// a wrong one loses no matches. The lens, the motion of each pair and the points are then estimated
// together. Returns a finding as the test of a run by its map does; empty also where there are not
// enough matches with depth. Takes some 0.3 s. See docs/misconfiguration.md, Lens.
std::optional<SensorFinding> CheckLens(const Dataset& dataset, const RgbdSensor& sensor,
                                       std::size_t begin = 0, std::size_t end = SIZE_MAX);

}  // namespace highwall
