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
  kImpossible,                // readings above any sensor's range: !IsPossible()
  kOutOfOrder,                // stamps that decrease
  kDuplicates,                // stamps that occur twice
  kOtherClock,                // no reading lies within the video
  kClockRate,                 // stamps that elapse faster or slower than those of the video
  kStartsLate,                // after the video
  kEndsEarly,                 // before the video
  kGaps,                      // steps between readings that are too long
  kFrozenGyroscope,           // repeats one reading
  kFrozenAccelerometer,       // likewise
  kRepeatedReadings,          // each is held for the same number of stamps
  kGyroscopeInDegrees,        // deg/s instead of rad/s
  kAccelerometerInG,          // g instead of m/s^2
  kAccelerometerImplausible,  // in no known unit
  kGravityRemoved,            // an acceleration instead of the specific force
  kColumnsExchanged,          // the accelerometer's in place of the gyroscope's
  kAccelerometerReversed,     // reads gravity instead of the specific force
  kRangeExceeded,             // readings beyond the stated range of a sensor
};

enum class ImuSeverity {
  kWarning,  // the remaining readings, RepairImu(), are valid
  kFatal,    // do not use the IMU: continue with RGB-D alone
};

struct ImuFinding {
  ImuFindingKind kind = ImuFindingKind::kEmpty;
  ImuSeverity severity = ImuSeverity::kFatal;
  std::string text;  // one line for people: the finding, and the likely unit or what to do
  // Index of the first affected reading, if readings are left out.
  std::optional<std::size_t> reading = {};
};

struct ImuCheckOptions {
  double max_step = 0.1;       // [s] > 0; a longer step between readings is a gap
  int frozen_readings = 50;    // >= 2; as many equal readings while the other sensor changes
  double max_bad_share = 0.1;  // in [0, 1]; of readings not finite, and of impossible ones
  // [rad/s] > 0; RMS of all but the max_bad_share largest; a camera that rotates faster sees
  // nothing
  double max_angular_rate = 6.0;
  double rate = 0.0;  // [Hz] >= 0; nominal, ImuCalibration::rate; 0: unknown

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// Checks for faults that make an IMU useless or suspicious, the worst first; empty if there is
// none. video: in the clock of the IMU. Units are judged from the readings themselves: gravity is
// 9.8 m/s^2 long, and the gyroscope must explain how its direction rotates. The sign of gravity
// cannot be judged in this way: see AccelerometerReversed(). Throws InvalidArgument for bad
// options.
std::vector<ImuFinding> CheckImu(std::span<const ImuSample> samples, const VideoSpan& video,
                                 const ImuCheckOptions& options = {});

bool HasFatal(std::span<const ImuFinding> findings);

// Returns the readings in order, without those that are not finite, impossible or duplicate, and
// converted to m/s^2 if `findings` has a warning that they are in g; if it has one of repeated
// readings, the first of each run stays and the others are interpolated.
std::vector<ImuSample> RepairImu(std::span<const ImuSample> samples,
                                 std::span<const ImuFinding> findings);

// Checks the result of RepairImu() against the ranges of the calibration, which may be in a wrong
// unit: a range that more than a few stray readings exceed becomes infinite, with a warning.
std::vector<ImuFinding> DropExceededRanges(std::span<const ImuSample> repaired,
                                           ImuCalibration* calibration);

// Finding for estimators, which detect it when only the negated accelerometer agrees with the
// video.
ImuFinding AccelerometerReversed();

}  // namespace highwall
