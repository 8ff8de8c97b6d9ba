#include <highwall/frontend/input/imu_check.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <utility>

#include <Eigen/Geometry>

#include <highwall/core/error.h>
#include <highwall/core/so3.h>
#include <highwall/internal/median.h>
#include <highwall/internal/number_text.h>
#include <highwall/internal/require.h>

#include "input/imu_repetition.h"

namespace highwall {
namespace {

constexpr double kMetresPerG = 9.80665;  // [m/s^2]
constexpr double kRadiansPerDegree = std::numbers::pi / 180.0;

using Kind = ImuFindingKind;
using Sensor = Eigen::Vector3d ImuSample::*;

std::string Rounded(double value) {
  return RoundedText(value, 3);
}

// Returns the finite readings in order, each stamp once: the first of several is kept.
std::vector<ImuSample> InOrder(std::span<const ImuSample> samples) {
  std::vector<ImuSample> ordered;
  std::copy_if(samples.begin(), samples.end(), std::back_inserter(ordered), IsFinite);
  std::stable_sort(ordered.begin(), ordered.end(),
                   [](const ImuSample& a, const ImuSample& b) { return a.stamp < b.stamp; });
  const auto end =
      std::unique(ordered.begin(), ordered.end(),
                  [](const ImuSample& a, const ImuSample& b) { return a.stamp == b.stamp; });
  ordered.erase(end, ordered.end());
  return ordered;
}

// Quantiles of the norms of a sensor's readings.
struct NormSpread {
  double tenth = 0.0, median = 0.0;  // the quantiles at 10 % and 50 %

  // Gravity is always present; rotations, and accelerations without gravity, vanish at times.
  bool IsNarrow(double share = 0.7) const { return tenth > share * median; }
};

NormSpread SpreadOf(const std::vector<ImuSample>& samples, Sensor sensor) {
  std::vector<double> norms;
  for (const ImuSample& sample : samples) norms.push_back((sample.*sensor).norm());
  const auto tenth = norms.begin() + static_cast<std::ptrdiff_t>(norms.size() / 10);
  std::nth_element(norms.begin(), tenth, norms.end());
  return {*tenth, UpperMedian(norms)};
}

// Returns whether the norms are those of gravity [m/s^2], or of gravity [g]: rates of about 1 rad/s
// also have norms of about 1, but with a wider spread.
bool IsGravity(const NormSpread& norms) {
  return norms.IsNarrow() && std::abs(norms.median - kMetresPerG) < 0.15 * kMetresPerG;
}
bool IsGravityInG(const NormSpread& norms) {
  return norms.IsNarrow(0.9) && std::abs(norms.median - 1.0) < 0.15;
}

bool IsInG(const ImuFinding& finding) {
  return finding.kind == Kind::kAccelerometerInG && finding.severity == ImuSeverity::kWarning;
}

ImuSample FromG(ImuSample sample) {
  sample.accelerometer *= kMetresPerG;
  return sample;
}

// Collects findings about one recording.
class Checker {
 public:
  Checker(std::span<const ImuSample> samples, const VideoSpan& video,
          const ImuCheckOptions& options)
      : samples_(samples), video_(video), options_(options), usable_(InOrder(samples)) {}

  std::vector<ImuFinding> Run() {
    CheckFinite();
    if (usable_.empty()) {
      Add(Kind::kEmpty, ImuSeverity::kFatal, "holds no reading that can be used");
      return findings_;
    }
    CheckOrder();
    if (ColumnsAreExchanged()) return findings_;
    CheckAccelerometerUnit();
    CheckGyroscopeRate();
    CheckPossible();
    if (usable_.empty()) return findings_;
    CheckSpan();
    CheckClockRate();
    CheckGaps();
    CheckFrozen("gyroscope", Kind::kFrozenGyroscope, &ImuSample::gyroscope,
                &ImuSample::accelerometer);
    CheckFrozen("accelerometer", Kind::kFrozenAccelerometer, &ImuSample::accelerometer,
                &ImuSample::gyroscope);
    CheckRepeated("gyroscope", &ImuSample::gyroscope);
    CheckRepeated("accelerometer", &ImuSample::accelerometer);
    if (!HasFatalOf(Kind::kGyroscopeInDegrees)) CheckGyroscopeByGravity();
    std::stable_sort(
        findings_.begin(), findings_.end(), [](const ImuFinding& a, const ImuFinding& b) {
          return a.severity == ImuSeverity::kFatal && b.severity != ImuSeverity::kFatal;
        });
    return findings_;
  }

 private:
  void Add(Kind kind, ImuSeverity severity, std::string text) {
    findings_.push_back({kind, severity, std::move(text)});
  }

  // Adds a finding for readings that are left out; too many of them are fatal.
  template <typename Predicate>
  void AddBad(Kind kind, const Predicate& is_bad, const std::string& what) {
    const auto first = std::find_if(samples_.begin(), samples_.end(), is_bad);
    if (first == samples_.end()) return;
    const auto bad = std::count_if(first, samples_.end(), is_bad);
    const double share = static_cast<double>(bad) / static_cast<double>(samples_.size());
    const bool fatal = share > options_.max_bad_share;
    Add(kind, fatal ? ImuSeverity::kFatal : ImuSeverity::kWarning,
        std::to_string(bad) + " of " + std::to_string(samples_.size()) + " readings are " + what +
            (fatal ? "" : "; left out"));
    findings_.back().reading = static_cast<std::size_t>(first - samples_.begin());
  }

  void CheckFinite() {
    AddBad(
        Kind::kNotFinite, [](const ImuSample& sample) { return !IsFinite(sample); },
        "NaN or infinite");
  }

  // If the unit is unknown, no limit can be checked.
  void CheckPossible() {
    if (HasFatalOf(Kind::kAccelerometerImplausible) || HasFatalOf(Kind::kAccelerometerInG) ||
        HasFatalOf(Kind::kGravityRemoved) || HasFatalOf(Kind::kGyroscopeInDegrees)) {
      return;
    }
    const bool in_g = std::any_of(findings_.begin(), findings_.end(), IsInG);
    const auto impossible = [in_g](const ImuSample& sample) {
      return IsFinite(sample) && !IsPossible(in_g ? FromG(sample) : sample);
    };
    AddBad(Kind::kImpossible, impossible,
           "beyond what any sensor measures (" + std::to_string(std::lround(kMaxAngularRate)) +
               " rad/s, " + std::to_string(std::lround(kMaxSpecificForce)) + " m/s^2)");
    std::erase_if(usable_, impossible);
  }

  bool HasFatalOf(Kind kind) const {
    return std::any_of(findings_.begin(), findings_.end(), [kind](const ImuFinding& finding) {
      return finding.kind == kind && finding.severity == ImuSeverity::kFatal;
    });
  }

  void CheckOrder() {
    std::size_t back = 0;
    for (std::size_t i = 1; i < samples_.size(); ++i) {
      if (samples_[i].stamp < samples_[i - 1].stamp) ++back;
    }
    if (back > 0) {
      Add(Kind::kOutOfOrder, ImuSeverity::kWarning,
          std::to_string(back) + " stamps are smaller than the one before; sorted");
    }
    const std::size_t finite =
        static_cast<std::size_t>(std::count_if(samples_.begin(), samples_.end(), IsFinite));
    if (const std::size_t copies = finite - usable_.size(); copies > 0) {
      Add(Kind::kDuplicates, ImuSeverity::kWarning,
          std::to_string(copies) + " stamps are there twice; the first reading stays");
    }
  }

  // A driver that counts readings of another rate stretches stamps to twice or half their length.
  // Rate and span must tell the same: a rate that was stated wrongly is harmless by itself, and so
  // is a recording that lasts longer than its video.
  void CheckClockRate() {
    constexpr double kSame = 0.05;     // relative difference of what is the same
    constexpr double kMargins = 1.5;   // [s] of readings before and after a video, together
    constexpr double kShortest = 3.0;  // [s] of a video
    const double video = ToSeconds(video_.end - video_.begin);
    const double span = ToSeconds(usable_.back().stamp - usable_.front().stamp);
    if (options_.rate <= 0.0 || video < kShortest || span <= 0.0) return;
    std::vector<double> steps;
    for (std::size_t i = 1; i < usable_.size(); ++i) {
      steps.push_back(ToSeconds(usable_[i].stamp - usable_[i - 1].stamp));
    }
    const double rate = static_cast<double>(steps.size()) / span;
    const double stretch = options_.rate / rate;
    const auto is = [](double value, double expected) {
      return std::abs(value / expected - 1.0) < kSame;
    };
    if (!is(stretch, 2.0) && !is(stretch, 0.5)) return;
    const double stated = span / stretch;
    const bool agrees = stated > (1.0 - kSame) * video && stated < video + kMargins;
    const bool agrees_as_it_is = span > (1.0 - kSame) * video && span < video + kMargins;
    if (!agrees || agrees_as_it_is || !is(UpperMedian(std::move(steps)), 1.0 / rate)) return;
    Add(Kind::kClockRate, ImuSeverity::kFatal,
        "readings come at " + Rounded(rate) + " Hz over " + Rounded(span) +
            " s, not at the stated " + Rounded(options_.rate) + " Hz over the " + Rounded(video) +
            " s of the video: divide the differences of their stamps by " + Rounded(stretch));
  }

  void CheckSpan() {
    const Stamp first = usable_.front().stamp, last = usable_.back().stamp;
    if (first > video_.end || last < video_.begin) {
      Add(Kind::kOtherClock, ImuSeverity::kFatal,
          "readings from " + FormatStamp(first) + " to " + FormatStamp(last) +
              " s do not meet the video, " + FormatStamp(video_.begin) + " to " +
              FormatStamp(video_.end) + " s: another clock");
      return;
    }
    if (const double late = ToSeconds(first - video_.begin); late > options_.max_step) {
      Add(Kind::kStartsLate, ImuSeverity::kWarning,
          "begins " + Rounded(late) + " s after the video; RGB-D alone until then");
    }
    if (const double early = ToSeconds(video_.end - last); early > options_.max_step) {
      Add(Kind::kEndsEarly, ImuSeverity::kWarning,
          "ends " + Rounded(early) + " s before the video; RGB-D alone from there");
    }
  }

  void CheckGaps() {
    std::size_t gaps = 0, longest = 1;
    const auto step = [this](std::size_t i) { return usable_[i].stamp - usable_[i - 1].stamp; };
    for (std::size_t i = 1; i < usable_.size(); ++i) {
      if (ToSeconds(step(i)) > options_.max_step) ++gaps;
      if (step(i) > step(longest)) longest = i;
    }
    if (gaps == 0) return;
    Add(Kind::kGaps, ImuSeverity::kWarning,
        std::to_string(gaps) + (gaps == 1 ? " gap" : " gaps") + " above " +
            Rounded(options_.max_step) + " s, the longest of " + Rounded(ToSeconds(step(longest))) +
            " s at " + FormatStamp(usable_[longest - 1].stamp) + "; RGB-D alone across them");
  }

  // Frozen: equal from the first reading to the last, or for long while the other sensor changes.
  void CheckFrozen(const char* name, Kind kind, Sensor sensor, Sensor other) {
    const auto shortest = static_cast<std::size_t>(options_.frozen_readings);
    for (std::size_t begin = 0, end = 0; begin < usable_.size(); begin = end) {
      bool other_changes = false;
      for (end = begin + 1; end < usable_.size() && usable_[end].*sensor == usable_[begin].*sensor;
           ++end) {
        other_changes |= usable_[end].*other != usable_[begin].*other;
      }
      const bool all = end - begin == usable_.size();
      if (end - begin < shortest || !(all || other_changes)) continue;
      Add(kind, ImuSeverity::kFatal,
          std::string(name) + " is frozen: it repeats one reading " +
              (all ? "from beginning to end" : "at " + FormatStamp(usable_[begin].stamp)));
      return;
    }
  }

  void CheckRepeated(const char* name, Sensor sensor) {
    const int repetitions = RepetitionsOf(usable_, sensor);
    if (repetitions == 1) return;
    const double duration = ToSeconds(usable_.back().stamp - usable_.front().stamp);
    const double rate = static_cast<double>(usable_.size() - 1) / duration;
    Add(Kind::kRepeatedReadings, ImuSeverity::kWarning,
        std::string(name) + " repeats each reading " + std::to_string(repetitions) +
            " times, an effective rate of " + Rounded(rate / repetitions) + " Hz of " +
            Rounded(rate) + " Hz; interpolated");
  }

  // Gravity is in the columns of the gyroscope and not in those of the accelerometer; no other unit
  // would explain that.
  bool ColumnsAreExchanged() {
    const NormSpread first = SpreadOf(usable_, &ImuSample::gyroscope);
    const NormSpread second = SpreadOf(usable_, &ImuSample::accelerometer);
    if (IsGravity(second) || IsGravityInG(second)) return false;
    if (!IsGravity(first) && !IsGravityInG(first)) return false;
    Add(Kind::kColumnsExchanged, ImuSeverity::kFatal,
        "the columns of the accelerometer come first: those of the gyroscope hold gravity, a "
        "median norm of " +
            Rounded(first.median) +
            "; write the gyroscope first, or a heading that names them: t,ax,ay,az,gx,gy,gz");
    return true;
  }

  void CheckAccelerometerUnit() {
    const NormSpread norms = SpreadOf(usable_, &ImuSample::accelerometer);
    const double norm = norms.median;
    constexpr double kLowest = 5.0, kHighest = 20.0;  // [m/s^2] for a hand-held camera
    if (norm >= kLowest && norm <= kHighest) return;
    const std::string median = "accelerometer: the median norm is " + Rounded(norm);
    if (norm < kLowest && !norms.IsNarrow()) {
      Add(Kind::kGravityRemoved, ImuSeverity::kFatal,
          median +
              ", where gravity alone makes 9.8 m/s^2, and varies: gravity was likely taken "
              "off already; record the accelerometer as it reads, with gravity");
    } else if (std::abs(norm - 1.0) < 0.05) {
      Add(Kind::kAccelerometerInG, ImuSeverity::kWarning,
          median + ": it is in g, not in m/s^2; converted");
    } else if (norm > 0.5 && norm < 2.0) {
      Add(Kind::kAccelerometerInG, ImuSeverity::kFatal,
          median + ": it is likely in g, not in m/s^2; multiply by 9.80665");
    } else {
      Add(Kind::kAccelerometerImplausible, ImuSeverity::kFatal,
          median + ", where gravity alone makes 9.8 m/s^2: the unit is unknown");
    }
  }

  // Uses all readings but the largest ones, as many as may be left out elsewhere.
  void CheckGyroscopeRate() {
    std::vector<double> squares;
    for (const ImuSample& sample : usable_) squares.push_back(sample.gyroscope.squaredNorm());
    const double kept =
        std::ceil((1.0 - options_.max_bad_share) * static_cast<double>(squares.size()));
    const auto end = squares.begin() + static_cast<std::ptrdiff_t>(std::max(kept, 1.0));
    std::nth_element(squares.begin(), end - 1, squares.end());
    const double rms = std::sqrt(std::accumulate(squares.begin(), end, 0.0) /
                                 static_cast<double>(end - squares.begin()));
    if (rms <= options_.max_angular_rate) return;
    Add(Kind::kGyroscopeInDegrees, ImuSeverity::kFatal,
        "gyroscope: the RMS rate is " + Rounded(rms) +
            ": it is likely in deg/s, not in rad/s; multiply by 0.0174533");
  }

  void CheckGyroscopeByGravity() {
    if (!DegreesExplainGravity()) return;
    Add(Kind::kGyroscopeInDegrees, ImuSeverity::kFatal,
        "gyroscope: taken for deg/s it explains how gravity turns, taken for rad/s it does not: "
        "it is likely in deg/s; multiply by 0.0174533");
  }

  // Returns the angle [rad] between gravity's direction at the end of [begin, end) and that at its
  // beginning rotated by the gyroscope times `scale`; the directions are means over a tenth of the
  // readings.
  double GravityError(std::size_t begin, std::size_t end, double scale) const {
    const std::size_t part = (end - begin) / 10;
    // from the current frame to that of begin
    Eigen::Quaterniond q = Eigen::Quaterniond::Identity();
    Eigen::Vector3d first = Eigen::Vector3d::Zero(), last = first;
    for (std::size_t i = begin; i < end; ++i) {
      if (i > begin) {
        const double step = ToSeconds(usable_[i].stamp - usable_[i - 1].stamp);
        q = q * so3::Exp(0.5 * step * scale * (usable_[i - 1].gyroscope + usable_[i].gyroscope));
      }
      if (i < begin + part) first += q * usable_[i].accelerometer;
      if (i >= end - part) last += q * usable_[i].accelerometer;
    }
    return std::atan2(first.cross(last).norm(), first.dot(last));
  }

  // Uses windows of half a second in which the readings taken as rad/s give a large rotation.
  bool DegreesExplainGravity() const {
    constexpr double kWindow = 0.5, kTurn = 1.0, kError = 0.2;  // [s], [rad], [rad]
    constexpr std::size_t kLeastReadings = 20, kLeastWindows = 3;
    std::vector<double> as_radians, as_degrees;
    for (std::size_t begin = 0, end = 0; end < usable_.size(); begin = end) {
      double turn = 0.0;
      for (end = begin + 1;
           end < usable_.size() && ToSeconds(usable_[end].stamp - usable_[begin].stamp) < kWindow;
           ++end) {
        turn +=
            usable_[end].gyroscope.norm() * ToSeconds(usable_[end].stamp - usable_[end - 1].stamp);
      }
      if (turn < kTurn || end - begin < kLeastReadings) continue;
      as_radians.push_back(GravityError(begin, end, 1.0));
      as_degrees.push_back(GravityError(begin, end, kRadiansPerDegree));
    }
    if (as_radians.size() < kLeastWindows) return false;
    const double radians = UpperMedian(std::move(as_radians));
    return radians > kError && UpperMedian(std::move(as_degrees)) < 0.25 * radians;
  }

  std::span<const ImuSample> samples_;
  VideoSpan video_;
  ImuCheckOptions options_;
  std::vector<ImuSample> usable_;
  std::vector<ImuFinding> findings_;
};

}  // namespace

void ImuCheckOptions::Validate() const {
  HIGHWALL_REQUIRE(max_step > 0.0,
                   "ImuCheckOptions::max_step must be positive, got " + FixedText(max_step));
  RequireAtLeast(frozen_readings, 2, "ImuCheckOptions::frozen_readings");
  HIGHWALL_REQUIRE(
      max_bad_share >= 0.0 && max_bad_share <= 1.0,
      "ImuCheckOptions::max_bad_share must be in [0, 1], got " + FixedText(max_bad_share));
  RequirePositive(max_angular_rate, "ImuCheckOptions::max_angular_rate");
  HIGHWALL_REQUIRE(rate >= 0.0, "ImuCheckOptions::rate must not be negative");
}

std::vector<ImuFinding> CheckImu(std::span<const ImuSample> samples, const VideoSpan& video,
                                 const ImuCheckOptions& options) {
  options.Validate();
  return Checker(samples, video, options).Run();
}

bool HasFatal(std::span<const ImuFinding> findings) {
  return std::any_of(findings.begin(), findings.end(), [](const ImuFinding& finding) {
    return finding.severity == ImuSeverity::kFatal;
  });
}

std::vector<ImuSample> RepairImu(std::span<const ImuSample> samples,
                                 std::span<const ImuFinding> findings) {
  std::vector<ImuSample> repaired = InOrder(samples);
  if (std::any_of(findings.begin(), findings.end(), IsInG)) {
    std::transform(repaired.begin(), repaired.end(), repaired.begin(), FromG);
  }
  std::erase_if(repaired, [](const ImuSample& sample) { return !IsPossible(sample); });
  const auto is_repetition = [](const ImuFinding& f) { return f.kind == Kind::kRepeatedReadings; };
  if (std::any_of(findings.begin(), findings.end(), is_repetition)) {
    for (const Sensor sensor : {&ImuSample::gyroscope, &ImuSample::accelerometer}) {
      if (RepetitionsOf(repaired, sensor) > 1) InterpolateRepeated(repaired, sensor);
    }
  }
  return repaired;
}

std::vector<ImuFinding> DropExceededRanges(std::span<const ImuSample> repaired,
                                           ImuCalibration* calibration) {
  constexpr double kTolerance = 1.1;  // of the range: tolerance between two sensors of one type
  // Minimum share and number of readings beyond the range: fewer are outliers.
  constexpr double kShare = 0.001;
  constexpr std::ptrdiff_t kFewest = 4;
  std::vector<ImuFinding> findings;
  const auto check = [&](Sensor sensor, double ImuCalibration::*range, const std::string& name,
                         const std::string& unit) {
    const double limit = kTolerance * (calibration->*range);
    const auto is_beyond = [&](const ImuSample& sample) {
      return (sample.*sensor).cwiseAbs().maxCoeff() > limit;
    };
    const auto first = std::find_if(repaired.begin(), repaired.end(), is_beyond);
    const std::ptrdiff_t beyond = std::count_if(first, repaired.end(), is_beyond);
    if (beyond < kFewest ||
        static_cast<double>(beyond) < kShare * static_cast<double>(repaired.size())) {
      return;
    }
    findings.push_back({Kind::kRangeExceeded, ImuSeverity::kWarning,
                        std::to_string(beyond) + " of " + std::to_string(repaired.size()) +
                            " readings of the " + name + " are beyond its range of " +
                            Rounded(calibration->*range) + " " + unit + ", the first at " +
                            FormatStamp(first->stamp) + ": imu: " + name +
                            "_range of the calibration is ignored; is it in " + unit + "?"});
    calibration->*range = std::numeric_limits<double>::infinity();
  };
  check(&ImuSample::gyroscope, &ImuCalibration::gyroscope_range, "gyroscope", "rad/s");
  check(&ImuSample::accelerometer, &ImuCalibration::accelerometer_range, "accelerometer", "m/s^2");
  return findings;
}

ImuFinding AccelerometerReversed() {
  return {Kind::kAccelerometerReversed, ImuSeverity::kFatal,
          "accelerometer: its sign is reversed, it reads gravity instead of the specific force "
          "(at rest it must point up); multiply by -1"};
}

}  // namespace highwall
