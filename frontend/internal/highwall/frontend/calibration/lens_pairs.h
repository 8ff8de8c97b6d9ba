#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include <highwall/frontend/input/dataset.h>
#include <highwall/frontend/input/sensor.h>
#include <highwall/frontend/input/sensor_verdict.h>

namespace [[gnu::visibility("default")]] highwall {

// Tests depth and lens by eight pairs of the images [begin, end) of a recording, without a map:
// their points are matched by descriptors and epipolar geometry alone, which holds for any lens, so
// that a wrong one loses no matches. Depth is wrong if another one explains their motion
// (DepthMotion). Otherwise the lens, the motion of each pair and the points are estimated together,
// and a finding is as that of the test of a run by its map. Empty where there are not enough
// matches with depth, unless cx and cy are exchanged (CheckExchangedCentre). Takes some 0.3 s. See
// docs/misconfiguration.md, Depth and Lens.
std::optional<SensorFinding> CheckPairs(const Dataset& dataset, const RgbdSensor& sensor,
                                        std::size_t begin = 0, std::size_t end = SIZE_MAX);

}  // namespace highwall
