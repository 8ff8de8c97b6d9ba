#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <numbers>
#include <utility>
#include <vector>

#include <fmt/core.h>
#include <Eigen/Core>
#include <Eigen/Geometry>

#include <highwall/core/pose.h>
#include <highwall/core/stamp.h>

#include "misuses.h"

namespace highwall::bench {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

Misuse Inertial(std::string fault, std::string strength, std::vector<SensorFault> expected,
                const std::function<void(apps::ImuFeed*)>& change) {
  return {std::move(fault), std::move(strength), std::move(expected), true,
          [change](StatedRecording* stated) { change(&stated->imu.value()); }};
}

Misuse Mount(std::string fault, std::string strength, std::vector<SensorFault> expected,
             const std::function<Pose(const Pose& T_BC)>& change) {
  return Inertial(
      std::move(fault), std::move(strength), std::move(expected),
      [change](apps::ImuFeed* imu) { imu->calibration.T_BC = change(imu->calibration.T_BC); });
}

Misuse Readings(std::string fault, std::string strength, std::vector<SensorFault> expected,
                const std::function<void(ImuSample*)>& change) {
  return Inertial(std::move(fault), std::move(strength), std::move(expected),
                  [change](apps::ImuFeed* imu) {
                    for (ImuSample& sample : imu->samples) change(&sample);
                  });
}

Misuse Rotated(std::string fault, std::string strength, double degrees,
               const Eigen::Vector3d& axis) {
  return Mount(
      std::move(fault), std::move(strength), {SensorFault::kImuMount}, [=](const Pose& T_BC) {
        const Eigen::Quaterniond R(Eigen::AngleAxisd(degrees * kDegree, axis.normalized()));
        return Pose(R * T_BC.q(), R * T_BC.p());
      });
}

std::vector<Misuse> MountMisuses() {
  const std::vector<SensorFault> mount{SensorFault::kImuMount};
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX(), y = Eigen::Vector3d::UnitY(),
                        z = Eigen::Vector3d::UnitZ(), oblique(1.0, 2.0, 3.0);
  return {Mount("T_BC inverted", "", mount, [](const Pose& T_BC) { return T_BC.Inverse(); }),
          Mount("T_BC left out", "", mount, [](const Pose&) { return Pose(); }),
          Mount("T_BC transposed", "its rotation", mount,
                [](const Pose& T_BC) { return Pose(T_BC.q().conjugate(), T_BC.p()); }),
          Rotated("T_BC rotated by 90 deg", "about x", 90.0, x),
          Rotated("T_BC rotated by 90 deg", "about y", 90.0, y),
          Rotated("T_BC rotated by 90 deg", "about z", 90.0, z),
          Rotated("T_BC a little off", "40 deg", 40.0, oblique),
          Rotated("T_BC a little off", "20 deg", 20.0, oblique),
          Rotated("T_BC a little off", "10 deg", 10.0, oblique),
          Mount("T_BC in centimetres", "", {SensorFault::kImuLeverArm},
                [](const Pose& T_BC) { return Pose(T_BC.q(), 100.0 * T_BC.p()); })};
}

std::vector<Misuse> AxesMisuses() {
  // An exchange of axes is a mirror; with another rotation it is a mount, too.
  const std::vector<SensorFault> axes{SensorFault::kImuAxes}, sign{SensorFault::kImuSign};
  const auto exchange = [](int a, int b) {
    return [a, b](ImuSample* sample) {
      std::swap(sample->gyroscope[a], sample->gyroscope[b]);
      std::swap(sample->accelerometer[a], sample->accelerometer[b]);
    };
  };
  return {
      Readings("IMU y and z exchanged", "", axes, exchange(1, 2)),
      Readings("IMU x and y exchanged", "", axes, exchange(0, 1)),
      Readings("IMU x and z exchanged", "", axes, exchange(0, 2)),
      Readings("one gyroscope axis turned", "x", axes,
               [](ImuSample* sample) { sample->gyroscope.x() *= -1.0; }),
      Readings("one gyroscope axis turned", "z", axes,
               [](ImuSample* sample) { sample->gyroscope.z() *= -1.0; }),
      Readings("all signs turned", "", sign,
               [](ImuSample* sample) {
                 sample->gyroscope *= -1.0;
                 sample->accelerometer *= -1.0;
               }),
      Readings("gyroscope sign", "", sign, [](ImuSample* sample) { sample->gyroscope *= -1.0; }),
      Readings("accelerometer sign", "", sign,
               [](ImuSample* sample) { sample->accelerometer *= -1.0; })};
}

// As drivers do that report the motion of a phone: readings without their mean.
Misuse GravityRemoved() {
  return Inertial("gravity removed", "", {SensorFault::kImuScale}, [](apps::ImuFeed* imu) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const ImuSample& sample : imu->samples) sum += sample.accelerometer;
    const Eigen::Vector3d mean = sum / static_cast<double>(imu->samples.size());
    for (ImuSample& sample : imu->samples) sample.accelerometer -= mean;
  });
}

std::vector<Misuse> ScaleMisuses() {
  const std::vector<SensorFault> scale{SensorFault::kImuScale};
  const auto gyroscope = [&](const char* strength, double factor) {
    return Readings("gyroscope unit", strength, scale,
                    [factor](ImuSample* sample) { sample->gyroscope *= factor; });
  };
  const auto accelerometer = [&](const char* strength, double factor) {
    return Readings("accelerometer unit", strength, scale,
                    [factor](ImuSample* sample) { sample->accelerometer *= factor; });
  };
  return {gyroscope("deg/s", 1.0 / kDegree), gyroscope("x 2", 2.0),       gyroscope("x 0.5", 0.5),
          accelerometer("g", 1.0 / 9.80665), accelerometer("x 1.2", 1.2), GravityRemoved()};
}

// Stamps elapse faster by `factor` from the first reading on.
Misuse Rate(double factor) {
  return Inertial("IMU stamps", fmt::format("x {}", factor), {SensorFault::kImuClock},
                  [factor](apps::ImuFeed* imu) {
                    const Stamp first = imu->samples.front().stamp;
                    for (ImuSample& sample : imu->samples) {
                      sample.stamp = first + FromSeconds(factor * ToSeconds(sample.stamp - first));
                    }
                  });
}

Misuse ClockApart(int milliseconds) {
  return Readings(
      "clocks apart", fmt::format("by {} ms", milliseconds), {SensorFault::kImuClock},
      [milliseconds](ImuSample* sample) { sample->stamp += Stamp{milliseconds} * 1'000'000; });
}

Misuse HeldAccelerations(std::size_t readings) {
  return Inertial("accelerations held", fmt::format("for {} readings", readings),
                  {SensorFault::kImuReadings}, [readings](apps::ImuFeed* imu) {
                    for (std::size_t i = 0; i < imu->samples.size(); ++i) {
                      imu->samples[i].accelerometer = imu->samples[i - i % readings].accelerometer;
                    }
                  });
}

// Half of the readings are left out, and `gap` [s] of every two seconds.
Misuse Gaps(double gap) {
  return Inertial("IMU with gaps", fmt::format("of {} s", gap), {SensorFault::kImuReadings},
                  [gap](apps::ImuFeed* imu) {
                    const Stamp first = imu->samples.front().stamp;
                    bool second = false;
                    std::erase_if(imu->samples, [&](const ImuSample& sample) {
                      second = !second;
                      const double t = std::fmod(ToSeconds(sample.stamp - first), 2.0);
                      return !second || t > 2.0 - gap;
                    });
                  });
}

// Of the middle of the recording, `gap` [s].
Misuse OneGap(double gap) {
  return Inertial("IMU with one gap", fmt::format("of {} s", gap), {SensorFault::kImuReadings},
                  [gap](apps::ImuFeed* imu) {
                    const Stamp first = imu->samples.front().stamp;
                    const double middle = 0.5 * ToSeconds(imu->samples.back().stamp - first);
                    std::erase_if(imu->samples, [&](const ImuSample& sample) {
                      return std::abs(ToSeconds(sample.stamp - first) - middle) < 0.5 * gap;
                    });
                  });
}

// Readings of a motion that has nothing to do with that of the images: their own, in another order.
Misuse OtherMotion(const char* strength,
                   const std::function<void(std::vector<ImuSample>*)>& order) {
  return Inertial("IMU of another recording", strength,
                  {SensorFault::kImuInconsistent, SensorFault::kImuClock},
                  [order](apps::ImuFeed* imu) {
                    std::vector<ImuSample> others = imu->samples;
                    order(&others);
                    for (std::size_t i = 0; i < others.size(); ++i) {
                      others[i].stamp = imu->samples[i].stamp;
                    }
                    imu->samples = std::move(others);
                  });
}

Misuse ClippedGyroscope(double limit) {
  return Readings("gyroscope clipped", fmt::format("at {} rad/s", limit),
                  {SensorFault::kImuReadings}, [limit](ImuSample* sample) {
                    sample->gyroscope = sample->gyroscope.cwiseMax(-limit).cwiseMin(limit);
                  });
}

}  // namespace

std::vector<Misuse> ImuMisuses() {
  std::vector<Misuse> all = MountMisuses();
  for (const auto& misuses : {AxesMisuses(), ScaleMisuses()}) {
    all.insert(all.end(), misuses.begin(), misuses.end());
  }
  all.insert(all.end(),
             {Rate(2.0),
              Rate(0.5),
              Rate(1.05),
              Rate(1000.0),
              Rate(0.001),
              ClockApart(1'000'000),
              ClockApart(300),
              ClockApart(100),
              ClockApart(50),
              HeldAccelerations(3),
              HeldAccelerations(6),
              HeldAccelerations(12),
              Gaps(0.3),
              Gaps(0.6),
              Gaps(1.2),
              OneGap(1.0),
              OneGap(0.3),
              OtherMotion("backwards",
                          [](std::vector<ImuSample>* samples) { std::ranges::reverse(*samples); }),
              OtherMotion("by half of it later",
                          [](std::vector<ImuSample>* samples) {
                            const auto half = static_cast<std::ptrdiff_t>(samples->size() / 2);
                            std::ranges::rotate(*samples, samples->begin() + half);
                          }),
              ClippedGyroscope(0.3),
              ClippedGyroscope(0.1)});
  return all;
}

}  // namespace highwall::bench
