#pragma once

#include <deque>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include <highwall/core/stamp.h>

namespace [[gnu::visibility("default")]] highwall {

// One reading of an inertial measurement unit, in the body frame B.
struct ImuSample {
  Stamp stamp = 0;                                          // [ns] in the IMU clock
  Eigen::Vector3d gyroscope = Eigen::Vector3d::Zero();      // [rad/s]
  Eigen::Vector3d accelerometer = Eigen::Vector3d::Zero();  // [m/s^2] specific force
};

using ImuBias = Eigen::Matrix<double, 6, 1>;  // [b_g b_a] of the readings, rad/s and m/s^2

// Upper bounds of physically possible readings. The widest ranges of MEMS parts are 400 g (ST
// H3LIS331DL) and 4000 deg/s (TDK ICM-20649); a larger value is a transmission fault, whatever the
// motion.
inline constexpr double kMaxSpecificForce = 4000.0;  // [m/s^2] per axis
inline constexpr double kMaxAngularRate = 70.0;      // [rad/s] per axis

// Longest plausible time between two readings [s]. A larger stamp difference is a clock or
// transmission fault, or the recording was paused.
inline constexpr double kMaxStampJump = 10.0;
// Number of mutually neighbouring readings after a jumped one from which the clock counts as
// shifted.
inline constexpr int kReadingsAfterJump = 10;

// Return whether all values are finite, and whether they and the stamp are also within these
// ranges.
bool IsFinite(const ImuSample& sample);
bool IsPossible(const ImuSample& sample);

// Readings of [start, end]: the first has the stamp `start`, the last `end`.
struct ImuInterval {
  std::vector<ImuSample> samples;  // strictly increasing stamps, at least 2
  double largest_step = 0.0;       // [s] between consecutive readings of the sensor
  int gaps = 0;                    // number of steps above ImuBufferOptions::max_step

  bool HasGap() const { return gaps > 0; }
};

// Options of ImuBuffer.
struct ImuBufferOptions {
  double max_step = 0.1;  // [s] > 0; a longer step between readings is a gap
  double horizon = 30.0;  // [s] > max_step; older readings are discarded

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// Result of adding a reading to an ImuBuffer.
enum class ImuSampleStatus {
  kAdded,       // added as the newest reading
  kReordered,   // arrived late, inserted in order of stamps
  kDuplicate,   // a reading with this stamp exists: dropped, the first one is kept
  kTooOld,      // older than the readings already discarded: dropped
  kNotFinite,   // dropped
  kImpossible,  // beyond the range of any sensor, or a stamp beyond kMaxStamp: dropped
  kJumped,      // its stamp is too far from the previous ones (ImuBuffer::Add): dropped
};
// Returns "added", "reordered", "duplicate" and so on.
const char* ToString(ImuSampleStatus status);
// Returns why a reading was dropped and how to correct it; empty if it was not dropped.
const char* Advice(ImuSampleStatus status);

// Buffer of IMU readings, sorted by stamp, from which the interval between two images is extracted.
class ImuBuffer {
 public:
  // Throws InvalidArgument on bad options.
  explicit ImuBuffer(const ImuBufferOptions& options = {});

  // Drops a reading whose stamp is more than kMaxStampJump after the newest reading, or before it
  // by more than that and the horizon: it would make all others unusable. If the following readings
  // have neighbouring stamps, the clock has shifted, or was wrong before: after kReadingsAfterJump
  // of them, readings are accepted again, and those of a clock that was ahead are discarded.
  ImuSampleStatus Add(const ImuSample& sample);

  // Returns the readings of [start, end], linearly interpolated at both ends unless readings exist
  // there; empty if the buffer does not cover the interval. A gap is bridged and counted: the
  // caller decides whether to use such an interval. Throws InvalidArgument unless start < end.
  // docs/factors/imu_buffer.md, Eq. 1
  std::optional<ImuInterval> Between(Stamp start, Stamp end) const;

  bool empty() const { return samples_.empty(); }
  std::size_t size() const { return samples_.size(); }
  // Throw InvalidArgument if the buffer is empty.
  Stamp oldest() const;
  Stamp newest() const;

 private:
  // Returns whether the stamp is too far from the previous ones while the clock has not yet been
  // found to have shifted.
  bool Jumps(Stamp stamp);

  ImuBufferOptions options_;
  std::deque<ImuSample> samples_;
  std::optional<Stamp> forgotten_;  // stamp of the newest discarded reading
  std::optional<Stamp> jumped_;     // latest stamp of the current run of jumped readings
  int jumps_ = 0;                   // number of consecutive readings that jumped to the same time
};

}  // namespace highwall
