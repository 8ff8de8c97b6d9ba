#include "simulate/motion/imu_simulator.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>

#include <highwall/core/error.h>
#include <highwall/factors/imu_factor.h>
#include <highwall/internal/number_text.h>

namespace highwall::simulate {
namespace {

constexpr double kLead = 0.5;                // [s] before the first frame and after the last
constexpr double kMaxTimeOffset = 0.2;       // [s]
constexpr std::uint64_t kStream = 0x494d55;  // separates these numbers from the image noise
enum Purpose : std::uint64_t { kNoise, kWalk, kInitialBias, kShaking, kFaults };

using Vector6d = Eigen::Matrix<double, 6, 1>;

// Six standard normal numbers.
Vector6d Normals(const CounterRandom& random, std::uint64_t index) {
  Vector6d normals;
  for (std::uint64_t i = 0; i < 3; ++i) {
    normals.segment<2>(static_cast<Eigen::Index>(2 * i)) =
        random.Normals(3 * index + i).cast<double>();
  }
  return normals;
}

// (g, g, g, a, a, a).
Vector6d Sigmas(double gyroscope, double accelerometer) {
  Vector6d sigmas;
  sigmas << Eigen::Vector3d::Constant(gyroscope), Eigen::Vector3d::Constant(accelerometer);
  return sigmas;
}

void RequireNotNegative(double value, const char* field) {
  HIGHWALL_REQUIRE(std::isfinite(value) && value >= 0.0, std::string("ImuSimulationOptions::") +
                                                             field + " must not be negative, got " +
                                                             FixedText(value));
}

}  // namespace

ImuNoise ImuSimulationOptions::TrueNoise() const {
  return {.gyroscope = noise_ratio * noise.gyroscope,
          .accelerometer = noise_ratio * noise.accelerometer,
          .gyroscope_walk = noise_ratio * noise.gyroscope_walk,
          .accelerometer_walk = noise_ratio * noise.accelerometer_walk};
}

void ImuSimulationOptions::Validate() const {
  HIGHWALL_REQUIRE(rate >= 20.0 && rate <= 10000.0,
                   "ImuSimulationOptions::rate must be in [20, 10000] Hz, got " + FixedText(rate));
  HIGHWALL_REQUIRE(T_BC.IsFinite(), "ImuSimulationOptions::T_BC must be finite");
  noise.Validate();
  HIGHWALL_REQUIRE(
      std::isfinite(noise_ratio) && noise_ratio > 0.0,
      "ImuSimulationOptions::noise_ratio must be positive, got " + FixedText(noise_ratio));
  RequireNotNegative(gyroscope_bias, "gyroscope_bias");
  RequireNotNegative(accelerometer_bias, "accelerometer_bias");
  faults.Validate();
  HIGHWALL_REQUIRE(
      std::abs(time_offset) <= kMaxTimeOffset,
      "ImuSimulationOptions::time_offset must be in [-0.2, 0.2] s, got " + FixedText(time_offset));
  RequireNotNegative(vibration.minCoeff(), "vibration");
  HIGHWALL_REQUIRE(vibration.allFinite(), "ImuSimulationOptions::vibration must be finite");
  HIGHWALL_REQUIRE(
      vibration_low > 0.0 && vibration_low < vibration_high && vibration_high < 0.5 * rate,
      "ImuSimulationOptions: 0 < vibration_low < vibration_high < rate / 2 must hold, got " +
          FixedText(vibration_low) + " and " + FixedText(vibration_high));
}

ImuSimulator::ImuSimulator(const ImuSimulationOptions& options, std::uint64_t seed, Stamp begin,
                           Stamp end)
    : options_((options.Validate(), options)),
      random_(CounterRandom(seed).Stream(kStream)),
      sensor_(options.faults, random_.Stream(kFaults), options.rate),
      begin_(begin),
      first_(begin - FromSeconds(kLead + std::abs(options.time_offset))) {
  HIGHWALL_REQUIRE(begin <= end, "ImuSimulator: begin must not be after end");
  const double duration = ToSeconds(end - first_) + kLead + std::abs(options.time_offset);
  const auto count = static_cast<std::size_t>(std::ceil(duration * options_.rate)) + 1;

  biases_.assign(count, ImuBias::Zero());
  if (options_.ideal) return;
  const ImuNoise noise = options_.TrueNoise();
  const Vector6d step =
      Sigmas(noise.gyroscope_walk, noise.accelerometer_walk) / std::sqrt(options_.rate);
  biases_[0] = Normals(random_.Stream(kInitialBias), 0)
                   .cwiseProduct(Sigmas(options_.gyroscope_bias, options_.accelerometer_bias));
  const CounterRandom walk = random_.Stream(kWalk);
  for (std::size_t i = 1; i < count; ++i) {
    biases_[i] = biases_[i - 1] + Normals(walk, i).cwiseProduct(step);
  }
  for (std::size_t i = 0; i < count; ++i) {
    biases_[i] += sensor_.DriftAt(static_cast<double>(i) / options_.rate);
  }

  constexpr std::uint64_t kWaves = 24;  // enough for the sum to resemble noise
  const CounterRandom shaking = random_.Stream(kShaking);
  for (std::uint64_t i = 0; i < kWaves; ++i) {
    Wave wave;
    for (std::uint64_t axis = 0; axis < 3; ++axis) {
      const std::uint64_t counter = 2 * (3 * i + axis);
      // One frequency in each of kWaves equal parts of the band.
      const double place = (static_cast<double>(i) + shaking.Uniform(counter)) / kWaves;
      const auto k = static_cast<Eigen::Index>(axis);
      wave.frequency[k] =
          2.0 * std::numbers::pi *
          (options_.vibration_low + place * (options_.vibration_high - options_.vibration_low));
      wave.phase[k] = 2.0 * std::numbers::pi * shaking.Uniform(counter + 1);
    }
    waves_.push_back(wave);
  }
}

Stamp ImuSimulator::StampOf(std::size_t sample) const {
  return first_ +
         static_cast<Stamp>(std::llround(static_cast<double>(sample) * 1e9 / options_.rate));
}

ImuSample ImuSimulator::Ideal(const CameraMotion& motion) const {
  const Eigen::Quaterniond q_BC = options_.T_BC.q();
  const Eigen::Vector3d lever_C = options_.T_BC.Inverse().p();
  const Eigen::Vector3d g_W(0.0, 0.0, -kStandardGravity);
  const Eigen::Vector3d a_C = motion.T_WC.q().conjugate() * (motion.a_WC - g_W) +
                              motion.alpha_C.cross(lever_C) +
                              motion.w_C.cross(motion.w_C.cross(lever_C));
  return {0, q_BC * motion.w_C, q_BC * a_C};
}

ImuSimulator::Shaking ImuSimulator::ShakingAt(const CameraPath& path,
                                              const VibrationIntensity& intensity, double t) const {
  Shaking sum;
  if (options_.ideal || !intensity) return sum;
  for (const Wave& wave : waves_) {
    const Eigen::Array3d angle = (wave.frequency * t + wave.phase).array();
    sum.acceleration += angle.sin().matrix();
    sum.velocity -= (angle.cos() / wave.frequency.array()).matrix();
  }
  const CameraPath::Progress progress = path.ProgressAt(t);
  const double strength = progress.ds * intensity(progress.s);
  const double unit_rms = std::sqrt(2.0 / static_cast<double>(waves_.size()));
  return {strength * (unit_rms * sum.acceleration.cwiseProduct(options_.vibration)),
          strength * (unit_rms * sum.velocity.cwiseProduct(options_.vibration))};
}

std::vector<ImuSample> ImuSimulator::Samples(const CameraPath& path,
                                             const VibrationIntensity& intensity) const {
  const CounterRandom noise = random_.Stream(kNoise);
  const ImuNoise densities = options_.TrueNoise();
  const Vector6d sigmas =
      Sigmas(densities.gyroscope, densities.accelerometer) * std::sqrt(options_.rate);
  std::vector<ImuSample> samples;
  samples.reserve(biases_.size());
  for (std::size_t i = 0; i < biases_.size(); ++i) {
    const double t = PathSeconds(StampOf(i));
    ImuSample sample = Ideal(path.MotionAt(t));
    sample.stamp = StampOf(i) + FromSeconds(options_.time_offset);
    if (!options_.ideal) {
      sample.accelerometer += ShakingAt(path, intensity, t).acceleration;
      sample = sensor_.Distorted(sample);
      const Vector6d error = biases_[i] + Normals(noise, i).cwiseProduct(sigmas);
      sample.gyroscope += error.head<3>();
      sample.accelerometer += error.tail<3>();
    }
    samples.push_back(sample);
  }
  return options_.ideal ? samples : sensor_.Delivered(std::move(samples));
}

TrueState ImuSimulator::StateAt(const CameraPath& path, const VibrationIntensity& intensity,
                                Stamp stamp) const {
  const double t = PathSeconds(stamp);
  const CameraMotion motion = path.MotionAt(t);
  const Pose T_CB = options_.T_BC.Inverse();
  TrueState truth;
  truth.stamp = stamp;
  truth.state.T_WB = motion.T_WC * T_CB;
  truth.state.v_WB = motion.v_WC + motion.T_WC.q() * motion.w_C.cross(T_CB.p());
  truth.state.v_WB += truth.state.T_WB.q() * ShakingAt(path, intensity, t).velocity;

  const double index = std::clamp(ToSeconds(stamp - first_) * options_.rate, 0.0,
                                  static_cast<double>(biases_.size() - 1));
  const auto i = static_cast<std::size_t>(index);
  const std::size_t next = std::min(i + 1, biases_.size() - 1);
  truth.bias = biases_[i] + (index - static_cast<double>(i)) * (biases_[next] - biases_[i]);
  return truth;
}

}  // namespace highwall::simulate
