#pragma once

#include <deque>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include <highwall/core/stamp.h>

namespace [[gnu::visibility("default")]] highwall {

// One reading of an inertial measurement unit, in the body frame B.
struct ImuSample {
  Stamp stamp = 0;                                          // [ns] of the IMU's clock
  Eigen::Vector3d gyroscope = Eigen::Vector3d::Zero();      // [rad/s]
  Eigen::Vector3d accelerometer = Eigen::Vector3d::Zero();  // [m/s^2] specific force
};

using ImuBias = Eigen::Matrix<double, 6, 1>;  // [b_g b_a] of its readings, rad/s and m/s^2

// What no inertial sensor measures: the widest ranges of MEMS parts are 400 g (ST H3LIS331DL) and
// 4000 deg/s (TDK ICM-20649). A value beyond is a fault on the way, whatever the motion.
inline constexpr double kMaxSpecificForce = 4000.0;  // [m/s^2] of an axis
inline constexpr double kMaxAngularRate = 70.0;      // [rad/s] of an axis

// No sensor is silent for so long between two readings: a stamp that jumps farther is a fault of a
// clock or on the way, or the recording paused. [s]
inline constexpr double kMaxStampJump = 10.0;
// After so many readings that follow one that jumped, each as a neighbour, the clock has moved.
inline constexpr int kReadingsAfterJump = 10;

// Whether all values are finite, and whether they and the stamp are within these ranges too.
bool IsFinite(const ImuSample& sample);
bool IsPossible(const ImuSample& sample);

// The readings of [start, end]: the first has the stamp `start`, the last `end`.
struct ImuInterval {
  std::vector<ImuSample> samples;  // strictly increasing stamps, at least 2
  double largest_step = 0.0;       // [s] between neighbouring readings of the sensor
  int gaps = 0;                    // steps above ImuBufferOptions::max_step

  bool HasGap() const { return gaps > 0; }
};

// Of ImuBuffer.
struct ImuBufferOptions {
  double max_step = 0.1;  // [s] > 0; readings farther apart than this are a gap
  double horizon = 30.0;  // [s] > max_step; readings older than this are forgotten

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// What became of a reading that was given to an ImuBuffer.
enum class ImuSampleStatus {
  kAdded,       // the newest reading
  kReordered,   // came late, and was put in its place
  kDuplicate,   // its stamp is there already: dropped, the first one stays
  kTooOld,      // came after everything around it was forgotten: dropped
  kNotFinite,   // dropped
  kImpossible,  // beyond what any sensor measures, or a stamp beyond kMaxStamp: dropped
  kJumped,      // its stamp is too far from those before (ImuBuffer::Add): dropped
};
// "added", "reordered" and so on.
const char* ToString(ImuSampleStatus status);
// What is wrong with a reading that was dropped, and what to do; empty where it was not.
const char* Advice(ImuSampleStatus status);

// Orders the readings of an IMU by stamp, and cuts out what lies between two images.
class ImuBuffer {
 public:
  // Throws InvalidArgument on bad options.
  explicit ImuBuffer(const ImuBufferOptions& options = {});

  // A stamp that is more than kMaxStampJump after the newest reading, or before it by more than
  // that and the horizon, would end the use of all others, and is dropped. Where the readings that
  // follow say the same, the clock has moved, or was wrong before: after kReadingsAfterJump of them
  // they are taken again, and what a clock that was ahead has left is forgotten.
  ImuSampleStatus Add(const ImuSample& sample);

  // The readings of [start, end], linearly interpolated at both ends, unless readings are there.
  // Empty where the buffer does not reach from start to end. A gap is bridged and counted: it is
  // the caller's choice to use such an interval. Throws InvalidArgument unless start < end.
  // docs/factors/imu_buffer.md, Eq. 1
  std::optional<ImuInterval> Between(Stamp start, Stamp end) const;

  bool empty() const { return samples_.empty(); }
  std::size_t size() const { return samples_.size(); }
  // Throw InvalidArgument if the buffer is empty.
  Stamp oldest() const;
  Stamp newest() const;

 private:
  // Whether the stamp is too far from those before, as long as the clock has not moved for good.
  bool Jumps(Stamp stamp);

  ImuBufferOptions options_;
  std::deque<ImuSample> samples_;
  std::optional<Stamp> forgotten_;  // stamp of the newest reading that was forgotten
  std::optional<Stamp> jumped_;     // the latest stamp, where it jumped
  int jumps_ = 0;                   // readings in a row that jumped to the same time
};

}  // namespace highwall
