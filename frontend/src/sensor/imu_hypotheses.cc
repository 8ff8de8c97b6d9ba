#include "sensor/imu_hypotheses.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include <highwall/factors/imu_factor.h>
#include <highwall/internal/number_text.h>

#include "sensor/images_scale.h"
#include "sensor/imu_alignment.h"
#include "sensor/imu_axes.h"
#include "sensor/imu_readings.h"
#include "sensor/turned_mount.h"

namespace highwall {
namespace {

using Matrix3 = Eigen::Matrix3d;
using Vector3 = Eigen::Vector3d;

constexpr int kFewest = 15;  // rotations of 0.1 s, or changes of velocity
// [s] of the offset of the clocks: what the online estimate copes with from the beginning; what any
// reading is granted; what is searched.
constexpr double kToleratedOffset = 0.03, kNearOffset = 0.05, kFarOffset = 0.5;
constexpr double kNearStep = 0.01, kFarStep = 0.02;
// Least excess of the squared residuals over those of the free fit, in variances: chi-squared with
// nine degrees of freedom exceeds 28 once in a thousand; the rest is for errors of poses that last.
constexpr double kSignificant = 100.0;
constexpr double kSignificantOffset = 40.0;      // the same with one degree of freedom
constexpr double kSignificantLongOffset = 25.0;  // and twice the fewest rotations
// Excess relative to what the free fit explains, as an angle in radians: a mount, scale or delay
// that the online estimation copes with stays below the first; a hypothesis explains all below
// the second.
constexpr double kWrong = 0.35, kRight = 0.2;
// RMS of the excess below which the images may be at fault: over 0.1 s [rad], and as an
// acceleration. Images with focal lengths that are 2 % off bend positions by 2 % of the depth as
// they turn: at 3 m and 1 rad/s, in half a second, by 0.2 m/s^2.
constexpr double kTurnError = 1e-3, kAccelerationError = 0.3;  // [rad], [m/s^2]
// Of a gyroscope whose images turn little, as on a vehicle: where a single reading explains all of
// it, this much suffices. On right recordings of 2.5 s and more the excess was below 20 variances
// or 5 % of what the free fit explains.
constexpr int kFewestSmall = 25;
constexpr double kSignificantSmall = 50.0, kSmallTurnError = 5e-4;  // [], [rad]
// A camera this far from its IMU is doubtful by itself, and smaller errors count.
constexpr double kLongArm = 0.5, kAccelerationErrorOfArm = 0.08;  // [m], [m/s^2]
// Both sensors say that T_BC is turned by degrees: the sum of their decreases of the squared
// residuals, in variances, and the least of each. Chi-squared with three degrees of freedom exceeds
// 25 once in 60 000; the rotation is that of the gyroscope, so the accelerometer adds nothing by
// chance. On right recordings of 2.5 s and more each was at most 2.
constexpr double kSignificantMount = 25.0, kSignificantMountOfEach = 5.0;
// Without another explanation: RMS rotation of the images over 0.1 s [rad], and the share of its
// energy that remains.
constexpr double kMuchTurn = 0.01, kUnexplained = 0.5;
constexpr double kLongEnough = 3.0;  // [s] of motion from which the simplest explanation is named

double Share(double excess, double signal) {
  return excess / std::max(signal, 1e-12);
}

// Tests readings of the IMU against the images.
class Judge {
 public:
  Judge(const ImuAlignment& alignment, const ImuCalibration& calibration, double strictness = 1.0)
      : alignment_(alignment),
        calibration_(calibration),
        strictness_(strictness),
        configured_(ConfiguredReading(calibration.T_BC)) {}

  ImuJudgement Run() {
    FitGyroscope();
    if (near_.front().fit.size() < kFewest) return {};
    const std::optional<ImuReading> mount = SlightlyTurnedMount();
    const bool clock = IsPaceContradicted() || (IsClockContradicted() && !IsBetterThanClock(mount)),
               gyroscope = !clock && IsGyroscopeContradicted();
    const bool accelerometer = !gyroscope && !clock && IsAccelerometerContradicted();
    if (gyroscope || clock || accelerometer) return Explain(clock);
    if (const auto arm = UnitOfLeverArm()) return Named(*arm);
    if (auto finding = ScaleFinding()) {
      return {ImuAgreement::kContradicted, std::move(finding), true};
    }
    if (IsGyroscopeSlightlyContradicted()) {
      ImuJudgement judgement = Explain(false);
      if (judgement.is_named) return judgement;
    }
    if (mount) return Named(*mount);
    const Clocked& best = Best(configured_.gyroscope, near_);
    const double signal = best.fit.Signal(), n = best.fit.size();
    const bool is_much = signal > n * kMuchTurn * kMuchTurn;
    if (best.fit.Squared(configured_.gyroscope) < kUnexplained * signal) {
      return {.agreement = is_much ? ImuAgreement::kConsistent : ImuAgreement::kUndecided};
    }
    if (IsRateContradicted()) return Explain(true);
    if (!is_much) return {};
    return {.agreement = ImuAgreement::kUnconfirmed, .finding = Inconsistent()};
  }

 private:
  struct Clocked {
    ClockRelation clock;
    GyroscopeFit fit;
  };

  Matrix3 R_CB() const { return calibration_.T_BC.R().transpose(); }

  void FitGyroscope() {
    const auto fit = [&](double from, double to, double step, std::vector<Clocked>* fits) {
      const int steps = static_cast<int>(std::lround((to - from) / step));
      for (int i = 0; i <= steps; ++i) {
        const ClockRelation clock{1.0, calibration_.time_offset + from + i * step};
        fits->push_back({clock, alignment_.Gyroscope(clock)});
      }
    };
    fit(-kNearOffset, kNearOffset, kNearStep, &near_);
    far_ = near_;
    fit(-kFarOffset, -kNearOffset - kNearStep, kFarStep, &far_);
    fit(kNearOffset + kNearStep, kFarOffset, kFarStep, &far_);
    // Offsets at which readings are missing fit fewer rotations.
    int most = 0;
    for (const Clocked& c : far_) most = std::max(most, c.fit.size());
    std::erase_if(far_, [&](const Clocked& c) { return c.fit.size() < 0.9 * most; });
    free_ = &*std::ranges::min_element(far_, {},
                                       [](const Clocked& c) { return Mean(c, c.fit.Free()); });
  }

  static double Mean(const Clocked& clocked, const Matrix3& A) {
    const int n = clocked.fit.size();
    return n > 0 ? clocked.fit.Squared(A) / n : std::numeric_limits<double>::infinity();
  }

  static const Clocked& Best(const Matrix3& A, const std::vector<Clocked>& among) {
    return *std::ranges::min_element(among, {}, [&](const Clocked& c) { return Mean(c, A); });
  }

  // Excess of the squared residuals, and what the free fit explains.
  double ExplainedByFree() const {
    return free_->fit.Signal() - free_->fit.Squared(free_->fit.Free());
  }
  double Excess(const Clocked& at, const Matrix3& A) const {
    return (Mean(at, A) - Mean(*free_, free_->fit.Free())) * free_->fit.size();
  }
  // The free fit explains most of the images' rotations.
  bool IsFreeGood() const { return ExplainedByFree() > kUnexplained * free_->fit.Signal(); }

  bool IsGyroscopeContradicted() const {
    const double excess = Excess(Best(configured_.gyroscope, near_), configured_.gyroscope);
    return IsFreeGood() && excess > strictness_ * kSignificant * free_->fit.Variance() &&
           excess > strictness_ * kTurnError * kTurnError * free_->fit.size() &&
           Share(excess, ExplainedByFree()) > strictness_ * kWrong * kWrong;
  }

  bool IsGyroscopeSlightlyContradicted() const {
    const double excess = Excess(Best(configured_.gyroscope, near_), configured_.gyroscope);
    return free_->fit.size() >= kFewestSmall && IsFreeGood() &&
           excess > strictness_ * kSignificantSmall * free_->fit.Variance() &&
           excess > strictness_ * kSmallTurnError * kSmallTurnError * free_->fit.size() &&
           Share(excess, ExplainedByFree()) > strictness_ * kWrong * kWrong;
  }

  // [s] Deviation from the configured offset, without the rounding of the steps.
  double OffsetOf(const Clocked& clocked) const {
    return std::abs(clocked.clock.offset - calibration_.time_offset) - 0.1 * kNearStep;
  }

  bool IsClockContradicted() const {
    constexpr double kBetter = 1.3;  // of squared residuals, beyond what is tolerated
    std::vector<Clocked> tolerated = near_;
    std::erase_if(tolerated, [&](const Clocked& c) { return OffsetOf(c) > kToleratedOffset; });
    const Clocked& near = Best(configured_.gyroscope, tolerated);
    const Clocked& far = Best(configured_.gyroscope, far_);
    return OffsetOf(far) > kToleratedOffset &&
           IsBetterClock(
               near, far,
               far.fit.size() >= 2 * kFewest ? kSignificantLongOffset : kSignificantOffset,
               kBetter) &&
           Share(Excess(far, R_CB()), ExplainedByFree()) < kRight * kRight;
  }

  // In slow motion a clock that is far off imitates a turned mount.
  bool IsBetterThanClock(const std::optional<ImuReading>& mount) const {
    return mount && Mean(Best(mount->gyroscope, near_), mount->gyroscope) <
                        Mean(Best(configured_.gyroscope, far_), configured_.gyroscope);
  }

  // Whether images and readings agree by the clock b, and less by a. variances: of the excess.
  // ratio: of the squared residuals.
  bool IsBetterClock(const Clocked& a, const Clocked& b, double variances, double ratio) const {
    const double better = (Mean(a, R_CB()) - Mean(b, R_CB())) * b.fit.size();
    const double variance = std::min(b.fit.Variance(), free_->fit.Variance());
    const double least = b.fit.Squared(b.fit.Free()), explained = b.fit.Signal() - least;
    return explained > kUnexplained * b.fit.Signal() &&
           Share(b.fit.Squared(R_CB()) - least, explained) < kRight * kRight &&
           better > strictness_ * variances * variance && Mean(a, R_CB()) > ratio * Mean(b, R_CB());
  }

  // A clock that runs at another pace: as if a sensor of 208 Hz were stamped with 200 Hz. Its
  // offset in the middle of the poses is about that which fits best at the same pace.
  bool IsPaceContradicted() {
    constexpr double kSpan = 0.03, kStep = 0.01;  // [s]
    constexpr double kMuchBetter = 1.5;           // there are many paces
    const Clocked& same = Best(R_CB(), far_);
    std::optional<Clocked> best;
    for (const double pace : {0.02, 0.03, 0.04, 0.05, 0.06, 0.08, 0.1}) {
      for (const double rate : {1.0 - pace, 1.0 + pace}) {
        const double drift = (rate - 1.0) * alignment_.middle();
        for (double shift = -kSpan; shift <= kSpan + 0.5 * kStep; shift += kStep) {
          const ClockRelation clock{rate, same.clock.offset + shift - drift};
          Clocked other{clock, alignment_.Gyroscope(clock)};
          if (other.fit.size() < std::max(kFewestSmall, same.fit.size() - 2)) continue;
          if (!best || Mean(other, R_CB()) < Mean(*best, R_CB())) best = std::move(other);
        }
      }
    }
    if (!best || !IsBetterClock(same, *best, kSignificantLongOffset, kMuchBetter)) return false;
    rate_ = best->clock.rate;
    return true;
  }

  AccelerometerFit& Acceleration(const ClockRelation& clock) {
    for (auto& [known, fit] : accelerations_) {
      if (known.rate == clock.rate && known.offset == clock.offset) return fit;
    }
    accelerations_.emplace_back(clock, alignment_.Accelerometer(clock));
    return accelerations_.back().second;
  }

  // Whether a reading of the accelerometer fits much worse than a free one: in `wrong` of what that
  // explains.
  bool IsWorse(const ImuReading& reading, const ClockRelation& clock, double wrong) {
    const AccelerometerFit& fit = Acceleration(clock);
    if (fit.size() < kFewest) return false;
    const double free = fit.FreeSquared();
    const double excess =
        fit.Squared(reading.accelerometer, reading.lever_arm, reading.lever_sigma) - free;
    const double error =
        (configured_.lever_arm.norm() > kLongArm ? kAccelerationErrorOfArm : kAccelerationError) *
        fit.mean_weight();
    return fit.Signal() - free > kUnexplained * fit.Signal() &&
           excess > strictness_ * kSignificant * fit.Variance() &&
           excess > strictness_ * error * error * fit.size() &&
           Share(excess, fit.Signal() - free) > strictness_ * wrong * wrong;
  }

  bool IsAccelerometerContradicted() {
    const ClockRelation& clock = Best(configured_.gyroscope, near_).clock;
    if (!IsWorse(configured_, clock, kWrong)) return false;
    // A wrong scale is one of the depth, unless gravity tells (InertialInitializer).
    for (const double scale : ScalesOfImages()) {
      ImuReading scaled = configured_;
      scaled.accelerometer *= scale;
      scaled.lever_arm *= scale;
      if (!IsWorse(scaled, clock, kRight)) return false;
      scaled.lever_arm = configured_.lever_arm;
      if (!IsWorse(scaled, clock, kRight)) return false;
    }
    return true;
  }

  // The rate of the clock is searched last, because it needs images much older than the readings.
  bool IsRateContradicted() {
    for (const double rate : {2.0, 0.5}) {
      constexpr double kStep = 0.02;
      std::vector<Clocked> fits;
      for (int i = -50; i <= 50; ++i) {
        const ClockRelation clock{rate, calibration_.time_offset + i * kStep};
        fits.push_back({clock, alignment_.Gyroscope(clock)});
      }
      std::erase_if(fits, [](const Clocked& c) { return c.fit.size() < 2 * kFewest; });
      if (fits.empty()) continue;
      const Clocked& best = Best(R_CB(), fits);
      const double squared = best.fit.Squared(R_CB());
      if (squared > kRight * best.fit.Signal() ||
          best.fit.Signal() < kSignificant * best.fit.Variance()) {
        continue;
      }
      rate_ = rate;
      return true;
    }
    return false;
  }

  bool Explains(const ImuReading& reading) {
    const Clocked& best = Best(reading.gyroscope, near_);
    const double excess = Excess(best, reading.gyroscope);
    if (excess > 0.25 * kSignificant * free_->fit.Variance() &&
        Share(excess, ExplainedByFree()) > kRight * kRight) {
      return false;
    }
    return !IsWorse(reading, best.clock, kRight);
  }

  std::optional<ImuReading> UnitOfLeverArm();
  std::optional<SensorFinding> ScaleFinding();
  std::optional<ImuReading> SlightlyTurnedMount();
  std::vector<ImuReading> TurnedReadings();
  ImuReading FreeLeverArm();
  ImuJudgement Explain(bool clock);
  static ImuJudgement Named(const ImuReading& reading) {
    return {.agreement = ImuAgreement::kContradicted,
            .finding = SensorFinding{reading.fault, Trust::kDoubtful, reading.text,
                                     reading.remedy + "; the images are used alone"},
            .is_named = true};
  }

  static SensorFinding Inconsistent() {
    return {.fault = SensorFault::kImuInconsistent,
            .trust = Trust::kDoubtful,
            .text =
                "images and IMU contradict each other, and no single error of T_BC, axes, "
                "signs, units or clocks explains it",
            .remedy =
                "check the section imu of calibration.yaml and the readings; the images are "
                "used alone"};
  }
  SensorFinding Clock() const;

  const ImuAlignment& alignment_;
  const ImuCalibration& calibration_;
  double strictness_;  // > 0; factor of all squared limits of a contradiction
  ImuReading configured_;
  std::vector<Clocked> near_, far_;
  const Clocked* free_ = nullptr;
  double rate_ = 1.0;
  std::vector<std::pair<ClockRelation, AccelerometerFit>> accelerations_;
};

// Of a camera metres away from its IMU: the reading in cm or mm if that fits significantly better
// than the configuration does, and than any scale of the depth, which explains part of it.
std::optional<ImuReading> Judge::UnitOfLeverArm() {
  constexpr double kLeastError = 0.05;  // [m/s^2]
  if (configured_.lever_arm.norm() <= kLongArm) return std::nullopt;
  const AccelerometerFit& fit = Acceleration(Best(configured_.gyroscope, near_).clock);
  if (fit.size() < kFewest) return std::nullopt;
  double least = std::numeric_limits<double>::infinity();
  for (const double scale : ScalesOfImages()) {
    const Matrix3 A = scale * configured_.accelerometer;
    least = std::min({least, fit.Squared(A, configured_.lever_arm),
                      fit.Squared(A, scale * configured_.lever_arm)});
  }
  const double variances = fit.size() >= 2 * kFewest ? kSignificantLongOffset : kSignificantOffset;
  const double error = kLeastError * fit.mean_weight();
  const double gain = std::max(variances * fit.Variance(), error * error * fit.size());
  least = std::min(
      least, fit.Squared(configured_.accelerometer, configured_.lever_arm) - strictness_ * gain);
  std::optional<ImuReading> best;
  for (ImuReading& reading : SimpleReadings(calibration_.T_BC)) {
    if (reading.fault != SensorFault::kImuLeverArm) continue;
    const double squared = fit.Squared(reading.accelerometer, reading.lever_arm);
    if (squared >= least) continue;
    least = squared;
    best = std::move(reading);
  }
  return best;
}

// The readings know gravity: where its norm is right, the lengths of the images are wrong.
std::optional<SensorFinding> Judge::ScaleFinding() {
  constexpr double kNearGravity = 0.1;  // share
  const AccelerometerFit& fit = Acceleration(Best(configured_.gyroscope, near_).clock);
  const auto scale =
      ContradictedScale(fit, configured_.accelerometer, configured_.lever_arm, strictness_);
  if (!scale) return std::nullopt;
  const auto x = fit.Unknowns(*scale * configured_.accelerometer, *scale * configured_.lever_arm);
  const double norm = x.segment<3>(12).norm() / *scale;
  if (std::abs(norm / kStandardGravity - 1.0) > kNearGravity) {
    return SensorFinding{SensorFault::kImuScale, Trust::kDoubtful,
                         "accelerometer and images agree if its readings, of which gravity is " +
                             FixedText(norm, 2) + " m/s^2, are multiplied by " +
                             RoundedText(*scale, 3),
                         "give them in m/s^2; the images are used alone"};
  }
  return SensorFinding{SensorFault::kDepthScale, Trust::kNotTrusted,
                       "accelerometer and images agree if depth is " +
                           RoundedText(1.0 / *scale, 2) + " times what it is read as",
                       "multiply depth_factor by " + RoundedText(*scale, 2) +
                           " in calibration.yaml; the images are used alone"};
}

ImuReading Judge::FreeLeverArm() {
  ImuReading reading = configured_;
  reading.fault = SensorFault::kImuLeverArm;
  reading.lever_arm = Acceleration(Best(R_CB(), near_).clock).LeverArm(configured_.accelerometer);
  const Vector3 p_BC = calibration_.T_BC.R() * reading.lever_arm;
  reading.text = "accelerometer and images agree if the translation of T_BC is about [" +
                 FixedText(p_BC.x(), 2) + ", " + FixedText(p_BC.y(), 2) + ", " +
                 FixedText(p_BC.z(), 2) + "] m instead of [" +
                 FixedText(calibration_.T_BC.p().x(), 2) + ", " +
                 FixedText(calibration_.T_BC.p().y(), 2) + ", " +
                 FixedText(calibration_.T_BC.p().z(), 2) + "]";
  reading.remedy = "measure the camera's position on the IMU, in m";
  return reading;
}

// Too little for the limits of a contradiction, whose free fit may explain errors of the images: a
// rotation explains both sensors.
std::optional<ImuReading> Judge::SlightlyTurnedMount() {
  if (!IsFreeGood()) return std::nullopt;
  std::vector<GyroscopeFit> fits;
  for (const Clocked& clocked : near_) fits.push_back(clocked.fit);
  const auto turned = FindTurnedMount(fits, configured_.gyroscope);
  if (!turned) return std::nullopt;
  const Clocked& best = near_[turned->fit];
  const AccelerometerFit& fit = Acceleration(best.clock);
  if (fit.size() < kFewest) return std::nullopt;
  const double gain = (fit.Squared(configured_.accelerometer, configured_.lever_arm) -
                       fit.Squared(turned->R_CB, configured_.lever_arm)) /
                      fit.Variance();
  if (turned->gain + gain < strictness_ * kSignificantMount ||
      std::min(turned->gain, gain) < strictness_ * kSignificantMountOfEach ||
      Share(Excess(best, turned->R_CB), ExplainedByFree()) > kRight * kRight) {
    return std::nullopt;
  }
  return TurnedReading(calibration_.T_BC, turned->R_CB);
}

std::vector<ImuReading> Judge::TurnedReadings() {
  std::vector<ImuReading> all;
  all.push_back(TurnedReading(calibration_.T_BC, free_->fit.Rotation()));
  const std::vector<Matrix3> permutations = SignedPermutations();
  for (int sensors = 0; sensors < 3; ++sensors) {  // both, gyroscope, accelerometer
    const char* const name[] = {"IMU", "gyroscope", "accelerometer"};
    std::vector<std::pair<double, ImuReading>> some;
    for (const Matrix3& P : permutations) {
      ImuReading reading = configured_;
      if (sensors != 2) reading.gyroscope *= P;
      if (sensors != 1) reading.accelerometer *= P;
      if (sensors == 0) reading.lever_sigma = 0.3;
      reading.fault = SensorFault::kImuAxes;
      reading.text = std::string(name[sensors]) + " and images agree if the axes x, y, z of the " +
                     (sensors == 0 ? "readings" : name[sensors]) + " are " + AxesText(P);
      reading.remedy = "exchange its columns, or correct T_BC in calibration.yaml";
      const Clocked& best = Best(reading.gyroscope, near_);
      const double squared =
          sensors == 2 ? Acceleration(best.clock).Squared(reading.accelerometer, reading.lever_arm)
                       : Mean(best, reading.gyroscope);
      some.emplace_back(squared, std::move(reading));
    }
    std::ranges::sort(some, {}, [](const auto& item) { return item.first; });
    all.push_back(some.front().second);
  }
  return all;
}

SensorFinding Judge::Clock() const {
  SensorFinding finding{.fault = SensorFault::kImuClock, .trust = Trust::kDoubtful};
  if (rate_ != 1.0) {
    const bool is_close = std::abs(rate_ - 1.0) < 0.2;
    const std::string pace = is_close ? "about " + FixedText(100.0 * std::abs(rate_ - 1.0), 0) +
                                            " % " + (rate_ > 1.0 ? "faster than" : "slower than")
                                      : std::string(rate_ > 1.0 ? "twice" : "half") + " as fast as";
    finding.text =
        "gyroscope and images agree if the clock of the IMU runs " + pace + " that of the images";
    finding.remedy =
        "correct the stamps of the readings, which may be counted at another rate than the "
        "sensor's";
    return finding;
  }
  return ClockFinding(Best(R_CB(), far_).clock.offset, calibration_.time_offset);
}

ImuJudgement Judge::Explain(bool clock) {
  ImuJudgement judgement{.agreement = ImuAgreement::kContradicted};
  if (clock) {
    judgement.finding = Clock();
    judgement.is_named = true;
    return judgement;
  }
  const bool is_long = alignment_.duration() >= kLongEnough;
  std::vector<ImuReading> explaining;
  for (std::vector<ImuReading> readings :
       {SimpleReadings(calibration_.T_BC), std::vector{FreeLeverArm()}, TurnedReadings()}) {
    for (ImuReading& reading : readings) {
      if (Explains(reading)) explaining.push_back(std::move(reading));
    }
    if (!explaining.empty()) break;
  }
  if (explaining.empty() && IsRateContradicted()) return Explain(true);
  const bool is_unique = std::ranges::all_of(
      explaining, [&](const ImuReading& r) { return r.fault == explaining.front().fault; });
  if (!explaining.empty() && explaining.front().fault == SensorFault::kImuLeverArm) {
    // A unit explains it only if it does as well as any lever arm.
    ImuReading any = FreeLeverArm();
    const AccelerometerFit& fit = Acceleration(Best(R_CB(), near_).clock);
    const auto squared = [&](const ImuReading& r) {
      return fit.Squared(r.accelerometer, r.lever_arm);
    };
    if (squared(explaining.front()) - squared(any) > kSignificantOffset * fit.Variance()) {
      explaining.front() = std::move(any);
    }
  }
  judgement.is_named = !explaining.empty() && (is_unique || is_long);
  if (judgement.is_named) return Named(explaining.front());
  if (is_long) {
    judgement.finding = Inconsistent();
  }
  return judgement;
}

}  // namespace

SensorFinding ClockFinding(double offset, double stated) {
  return {SensorFault::kImuClock, Trust::kDoubtful,
          "gyroscope and images agree if the stamps of the IMU are " +
              FixedText(1e3 * std::abs(offset), 0) + " ms " +
              (offset > 0.0 ? "ahead of" : "behind") + " those of the images, instead of " +
              FixedText(1e3 * stated, 0) + " ms",
          "set time_offset: " + FixedText(offset, 3) + " in the section imu of calibration.yaml"};
}

ImuJudgement JudgeImu(const Trajectory& poses, std::span<const ImuSample> readings,
                      const ImuCalibration& calibration, double max_step) {
  if (poses.size() < 2 || readings.size() < 2) return {};
  ImuAlignment alignment(poses, readings, max_step, calibration.gyroscope_range,
                         calibration.accelerometer_range);
  ImuJudgement judgement = Judge(alignment, calibration).Run();
  if (judgement.agreement < ImuAgreement::kUnconfirmed) return judgement;
  // A shock is worst in few places, a wrong configuration everywhere: without the worst, a shock
  // leaves nothing, and a wrong configuration some of its excess.
  constexpr double kOfTrimmed = 0.3;
  const Eigen::Matrix3d R_CB = calibration.T_BC.R().transpose();
  const ClockRelation clock{1.0, calibration.time_offset};
  alignment.Trim(R_CB, R_CB * calibration.T_BC.p(), clock);
  const ImuJudgement trimmed = Judge(alignment, calibration, kOfTrimmed).Run();
  if (trimmed.agreement < ImuAgreement::kUnconfirmed) return {};
  return judgement;
}

}  // namespace highwall
