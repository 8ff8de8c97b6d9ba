#include "simulate/motion/imu_faults.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include <highwall/core/error.h>
#include <highwall/core/stamp.h>
#include <highwall/internal/number_text.h>

namespace highwall::simulate {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kMaxJitter = 0.2;  // of a period, so that stamps stay in order
enum FaultPurpose : std::uint64_t { kScales, kAxes, kGravity, kDrift, kJitter, kDropped, kShocks };

struct Field {
  const char* name;
  double ImuFaults::*value;
  double min, max;
};
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kTiny = std::numeric_limits<double>::min();
constexpr std::array<Field, 12> kFields{{
    {"gyroscope_scale", &ImuFaults::gyroscope_scale, 0.0, 0.5},
    {"accelerometer_scale", &ImuFaults::accelerometer_scale, 0.0, 0.5},
    {"misalignment", &ImuFaults::misalignment, 0.0, 0.1},
    {"g_sensitivity", &ImuFaults::g_sensitivity, 0.0, 1.0},
    {"gyroscope_range", &ImuFaults::gyroscope_range, kTiny, kInfinity},
    {"accelerometer_range", &ImuFaults::accelerometer_range, kTiny, kInfinity},
    {"gyroscope_drift", &ImuFaults::gyroscope_drift, 0.0, 10.0},
    {"accelerometer_drift", &ImuFaults::accelerometer_drift, 0.0, 100.0},
    {"warm_up", &ImuFaults::warm_up, kTiny, 1e9},
    {"stamp_jitter", &ImuFaults::stamp_jitter, 0.0, 1.0},
    {"dropped", &ImuFaults::dropped, 0.0, 0.5},
    {"blow_interval", &ImuFaults::blow_interval, 0.0, 1e9},
}};

// A 3 x 3 matrix of standard normal numbers.
Eigen::Matrix3d NormalMatrix(const CounterRandom& random, std::uint64_t first) {
  Eigen::Matrix3d m;
  for (Eigen::Index i = 0; i < 9; ++i) {
    m(i) = static_cast<double>(random.Normals(first + static_cast<std::uint64_t>(i)).x());
  }
  return m;
}

// Scales on the diagonal, cross-axis sensitivity off the diagonal.
Eigen::Matrix3d Axes(double scale, double misalignment, const Eigen::Matrix3d& scales,
                     const Eigen::Matrix3d& angles) {
  Eigen::Matrix3d axes = misalignment * angles;
  axes.diagonal() = Eigen::Vector3d::Ones() + scale * scales.diagonal();
  return axes;
}

}  // namespace

void ImuFaults::Validate() const {
  for (const Field& field : kFields) {
    const double value = this->*field.value;
    HIGHWALL_REQUIRE(
        value >= field.min && value <= field.max,
        std::string("ImuFaults::") + field.name + " is out of range: " + FixedText(value));
  }
}

ImuFaults HardImuFaults() {
  constexpr double kG = 9.81, kKelvins = 10.0;
  return {.gyroscope_scale = 0.005,
          .accelerometer_scale = 0.005,
          .misalignment = 0.3 * kDegree,
          .g_sensitivity = 0.1 * kDegree / kG,
          .gyroscope_range = 500.0 * kDegree,
          .accelerometer_range = 4.0 * kG,
          .gyroscope_drift = 0.015 * kDegree * kKelvins,
          .accelerometer_drift = 1e-3 * kG * kKelvins,
          .stamp_jitter = 2e-4,
          .dropped = 0.005};
}

ImuFaults ParseImuFaults(const std::string& text) {
  ImuFaults faults;
  TextReader parts(text);
  bool first = true;
  for (std::string part; std::getline(parts, part, ','); first = false) {
    if (first && part == "off") continue;
    if (first && part == "hard") {
      faults = HardImuFaults();
      continue;
    }
    const std::size_t equals = part.find('=');
    const auto field = std::ranges::find_if(
        kFields, [&](const Field& f) { return part.substr(0, equals) == f.name; });
    HIGHWALL_REQUIRE(field != kFields.end() && equals != std::string::npos,
                     "'" + part + "' is no fault of an IMU: off, hard, or name=value with one of " +
                         "gyroscope_scale, accelerometer_scale, misalignment, g_sensitivity, "
                         "gyroscope_range, accelerometer_range, gyroscope_drift, "
                         "accelerometer_drift, warm_up, stamp_jitter, dropped, blow_interval");
    const std::optional<double> value = ReadNumber<double>(part.substr(equals + 1));
    HIGHWALL_REQUIRE(value, "'" + part + "': " + field->name + " must be a number");
    faults.*field->value = *value;
  }
  faults.Validate();
  return faults;
}

FaultyImu::FaultyImu(const ImuFaults& faults, const CounterRandom& random, double rate)
    : faults_((faults.Validate(), faults)), random_(random), rate_(rate) {
  const CounterRandom scales = random.Stream(kScales), axes = random.Stream(kAxes);
  gyroscope_ = Axes(faults.gyroscope_scale, faults.misalignment, NormalMatrix(scales, 0),
                    NormalMatrix(axes, 0));
  accelerometer_ = Axes(faults.accelerometer_scale, faults.misalignment, NormalMatrix(scales, 9),
                        NormalMatrix(axes, 9));
  g_sensitivity_ = faults.g_sensitivity * NormalMatrix(random.Stream(kGravity), 0);
  const Eigen::Matrix3d drift = NormalMatrix(random.Stream(kDrift), 0);
  drift_ << faults.gyroscope_drift * drift.col(0), faults.accelerometer_drift * drift.col(1);
}

ImuBias FaultyImu::DriftAt(double t) const {
  return (1.0 - std::exp(-std::max(t, 0.0) / faults_.warm_up)) * drift_;
}

ImuSample FaultyImu::Distorted(const ImuSample& ideal) const {
  return {ideal.stamp, gyroscope_ * ideal.gyroscope + g_sensitivity_ * ideal.accelerometer,
          accelerometer_ * ideal.accelerometer};
}

ImuBias FaultyImu::ShockAt(double t) const {
  constexpr double kDuration = 0.06, kGyroscope = 3.0, kAccelerometer = 40.0;
  if (faults_.blow_interval <= 0.0) return ImuBias::Zero();
  const double span = std::floor(t / faults_.blow_interval);
  const CounterRandom random = random_.Stream(kShocks).Stream(static_cast<std::uint64_t>(span));
  const Eigen::Matrix3d axes = NormalMatrix(random, 0).colwise().normalized();
  const double begin = (span + static_cast<double>(random.Uniform(9))) * faults_.blow_interval;
  if (t < begin || t >= begin + kDuration) return ImuBias::Zero();
  ImuBias shock;
  shock << kGyroscope * axes.col(0), kAccelerometer * axes.col(1);
  return std::sin(std::numbers::pi * (t - begin) / kDuration) * shock;
}

std::vector<ImuSample> FaultyImu::Delivered(std::vector<ImuSample> readings) const {
  const CounterRandom jitter = random_.Stream(kJitter), dropped = random_.Stream(kDropped);
  const double most = kMaxJitter / rate_;
  std::vector<ImuSample> delivered;
  delivered.reserve(readings.size());
  for (std::size_t i = 0; i < readings.size(); ++i) {
    if (dropped.Uniform(i) < faults_.dropped) continue;
    ImuSample& reading = delivered.emplace_back(std::move(readings[i]));
    const ImuBias shock = ShockAt(static_cast<double>(i) / rate_);
    reading.gyroscope += shock.head<3>();
    reading.accelerometer += shock.tail<3>();
    reading.gyroscope =
        reading.gyroscope.cwiseMax(-faults_.gyroscope_range).cwiseMin(faults_.gyroscope_range);
    reading.accelerometer = reading.accelerometer.cwiseMax(-faults_.accelerometer_range)
                                .cwiseMin(faults_.accelerometer_range);
    const double late = faults_.stamp_jitter * static_cast<double>(jitter.Normals(i).x());
    reading.stamp += FromSeconds(std::clamp(late, -most, most));
  }
  return delivered;
}

}  // namespace highwall::simulate
