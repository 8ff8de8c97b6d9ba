#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include <highwall/factors/imu_buffer.h>
#include <highwall/frontend/input/dataset.h>
#include <highwall/frontend/input/sensor.h>

namespace [[gnu::visibility("default")]] highwall {

enum class ImuFindingKind {
  kEmpty,                     // no reading that could be used
  kNotFinite,                 // NaN or infinite readings
  kImpossible,                // readings beyond what any sensor measures: IsPossible()
  kOutOfOrder,                // stamps that go back in time
  kDuplicates,                // stamps that are there twice
  kOtherClock,                // no reading falls into the video
  kStartsLate,                // after the video
  kEndsEarly,                 // before the video
  kGaps,                      // steps between readings that are too long
  kFrozenGyroscope,           // repeats one reading
  kFrozenAccelerometer,       // likewise
  kGyroscopeInDegrees,        // deg/s instead of rad/s
  kAccelerometerInG,          // g instead of m/s^2
  kAccelerometerImplausible,  // in no unit that is known
  kGravityRemoved,            // an acceleration instead of the specific force
  kColumnsExchanged,          // the accelerometer's where the gyroscope's should be
  kAccelerometerReversed,     // reads gravity instead of the specific force
  kRangeDenied,               // readings beyond where a sensor is said to end
};
const char* ToString(ImuFindingKind kind);

enum class ImuSeverity {
  kWarning,  // what remains, RepairImu(), is sound
  kFatal,    // do not use the IMU: go on with RGB-D alone
};

struct ImuFinding {
  ImuFindingKind kind = ImuFindingKind::kEmpty;
  ImuSeverity severity = ImuSeverity::kFatal;
  std::string text;  // one line for people: what, and the likely unit or what to do
  // The first of the readings that are left out, where it is about such.
  std::optional<std::size_t> reading = {};
};

struct ImuCheckOptions {
  double max_step = 0.1;       // [s] > 0; readings farther apart than this are a gap
  int frozen_readings = 50;    // >= 2; as many equal ones, while the other sensor changes
  double max_bad_share = 0.1;  // in [0, 1]; of readings not finite, and of impossible ones
  // [rad/s] > 0; RMS of all but the max_bad_share largest; no camera that sees anything turns
  // faster
  double max_angular_rate = 6.0;

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// Looks for what makes an IMU useless or suspicious, the worst first; empty where all is well.
// video: in the clock of the IMU. Units are judged by what the readings say themselves: gravity is
// 9.8 m/s^2 long, and the gyroscope must explain how its direction turns. The sign of gravity
// cannot be judged in this way: see AccelerometerReversed(). Throws InvalidArgument for bad
// options.
std::vector<ImuFinding> CheckImu(std::span<const ImuSample> samples, const VideoSpan& video,
                                 const ImuCheckOptions& options = {});

bool HasFatal(std::span<const ImuFinding> findings);

// The readings in order, without those that are not finite, impossible or there twice, and in m/s^2
// where `findings` has a warning that they are in g.
std::vector<ImuSample> RepairImu(std::span<const ImuSample> samples,
                                 std::span<const ImuFinding> findings);

// What RepairImu() returned against the ranges that a calibration tells, such as one in another
// unit: a range that more than some stray readings leave becomes infinite, which a warning says.
std::vector<ImuFinding> DropDeniedRanges(std::span<const ImuSample> repaired,
                                         ImuCalibration* calibration);

// For estimators, which find it out when only the negated accelerometer agrees with the video.
ImuFinding AccelerometerReversed();

}  // namespace highwall
