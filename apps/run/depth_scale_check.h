#pragma once

#include <optional>

#include <highwall/frontend/calibration/depth_scale.h>
#include <highwall/frontend/inertial/inertial_report.h>
#include <highwall/frontend/input/sensor_verdict.h>

namespace highwall::apps {

// Whether the scale of the depth by the IMU means something: the IMU is in use, and its clock is
// aligned with that of the images. last: of the last frame.
bool IsScaleMeaningful(const InertialReport& last);

// Whether a finding is of the IMU: of its calibration, readings or clock.
bool IsOfImu(const SensorFinding& finding);
// Whether a finding of the IMU leaves no scale: images that contradict the IMU do not have its
// scale. Clocks that are apart alone do not contradict it, as long as it is in use.
bool LeavesNoScale(const SensorFinding& finding);

// Returns a finding if the scale is wrong by more than 5 % and by five standard deviations: a depth
// that is right, or off by 2 %, gives one at most once in a thousand recordings. depth_factor: as
// configured.
std::optional<SensorFinding> CheckDepthScale(const DepthScale& scale, double depth_factor);

}  // namespace highwall::apps
