#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

#include <opencv2/core.hpp>

#include <highwall/core/stamp.h>
#include <simulate/random.h>

#include "misuses.h"

namespace highwall::bench {
namespace {

constexpr std::uint64_t kSeed = 1;

Misuse Right(std::string name, bool inertial, std::function<void(StatedRecording*)> apply) {
  return {std::move(name), "", {}, inertial, std::move(apply)};
}

// Adds white noise with several times the stated densities.
void AddImuNoise(StatedRecording* stated) {
  constexpr double kTimes = 4.0;
  apps::ImuFeed& imu = stated->imu.value();
  const double root = kTimes * std::sqrt(imu.calibration.rate);
  const simulate::CounterRandom random(kSeed);
  for (std::size_t i = 0; i < imu.samples.size(); ++i) {
    const Eigen::Vector2f a = random.Normals(3 * i), b = random.Normals(3 * i + 1),
                          c = random.Normals(3 * i + 2);
    imu.samples[i].gyroscope +=
        root * imu.calibration.noise.gyroscope * Eigen::Vector3d(a.x(), a.y(), b.x());
    imu.samples[i].accelerometer +=
        root * imu.calibration.noise.accelerometer * Eigen::Vector3d(b.y(), c.x(), c.y());
  }
}

// Adds as much noise again as the sensor has.
void AddDepthNoise(StatedRecording* stated) {
  const RgbdSensor sensor = stated->sensor;
  stated->change_depth = [sensor](std::size_t frame, cv::Mat* stored) {
    const simulate::CounterRandom random = simulate::CounterRandom(kSeed).Stream(frame);
    std::uint64_t i = 0;
    for (std::uint16_t& value : cv::Mat_<std::uint16_t>(*stored)) {
      ++i;
      if (value == 0) continue;
      const double sigma = sensor.depth_noise.Sigma(value / sensor.depth_factor);
      const double noise = sensor.depth_factor * sigma * random.Normals(i).x();
      value = cv::saturate_cast<std::uint16_t>(value + noise);
    }
  };
}

void DelayImu(StatedRecording* stated) {
  for (ImuSample& sample : stated->imu.value().samples) sample.stamp += 20'000'000;  // [ns]
}

}  // namespace

std::vector<Misuse> RightRecordings() {
  const auto scale_focal = [](double factor) {
    return [factor](StatedRecording* stated) {
      stated->sensor.camera.fx *= factor;
      stated->sensor.camera.fy *= factor;
    };
  };
  const auto scale_depth = [](double factor) {
    return [factor](StatedRecording* stated) { stated->sensor.depth_factor *= factor; };
  };
  return {Right("right", false, [](StatedRecording*) {}),
          Right("right, with IMU", true, [](StatedRecording*) {}),
          Right("focal lengths 2 % long", false, scale_focal(1.02)),
          Right("focal lengths 2 % short", false, scale_focal(0.98)),
          Right("focal lengths 2 % long, with IMU", true, scale_focal(1.02)),
          Right("depth 2 % long", false, scale_depth(0.98)),
          Right("depth 2 % short", false, scale_depth(1.02)),
          Right("depth 2 % long, with IMU", true, scale_depth(0.98)),
          Right("noisy depth", false, AddDepthNoise),
          Right("IMU 20 ms late", true, DelayImu),
          Right("noisy IMU", true, AddImuNoise)};
}

}  // namespace highwall::bench
