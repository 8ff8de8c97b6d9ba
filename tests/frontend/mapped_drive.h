#pragma once

#include <optional>
#include <stdexcept>

#include <Eigen/Core>

#include <highwall/core/stamp.h>
#include <highwall/factors/imu_buffer.h>
#include <highwall/factors/imu_preintegration.h>
#include <highwall/internal/stopwatch.h>

#include "inertial/visual_inertial_window.h"
#include "mapped_place.h"

namespace highwall::testing {

// A window fed with an image every kImageStep. noise, density: as MappedPlace. doubt: [m] and
// tenths of a radian, where it is said that the start is known no better.
class MappedDrive {
 public:
  MappedDrive(const InertialSceneOptions& scene, const InertialOptions& options,
              const StartSigma& sigma = {}, double noise = 1.0, double doubt = 0.0, int density = 1)
      : place_(scene, noise, density), motion_(scene.motion) {
    InertialScene& truth = place_.scene();
    for (const ImuSample& reading : truth.Readings(0.0, kStart)) buffer_.Add(reading);
    InertialPrior prior = Start(truth, kStart, scene.time_offset, sigma);
    if (doubt > 0.0) {
      const Eigen::Vector3d position = Eigen::Vector3d::Constant(doubt * doubt);
      prior.estimate.covariance.diagonal().head<6>() << position, 0.01 * position;
    }
    window_.emplace(truth.calibration(), place_.model(), options, prior);
  }

  // map_drifts [m/s]: along x. blind: images show nothing.
  void Go(int images, double map_drifts = 0.0, bool blind = false) {
    for (int k = 0; k < images; ++k) {
      const double t = kStart + kImageStep * ++image_;
      InertialScene& truth = place_.scene();
      for (const ImuSample& reading : truth.Readings(read_ + 0.005, t + 0.05)) buffer_.Add(reading);
      read_ = t + 0.05;
      const Stamp to = FromSeconds(t + window_->time_offset());
      const auto interval = buffer_.Between(window_->newest().stamp, to);
      Require(interval.has_value(), "readings are missing");
      const ImuPreintegration imu(interval->samples, window_->newest().bias,
                                  {.noise = truth.calibration().noise});
      const Pose drift(Eigen::Quaterniond::Identity(), {map_drifts * kImageStep, 0, 0});
      place_.MoveMap(drift);
      T_MW_ = drift * T_MW_;
      const SeenLandmarks seen = place_.See(t);
      // The rate as the motion has it: the mean reading is a matter of RateAt().
      const Eigen::Vector3d omega_B = motion_.SampleAt(to).gyroscope;
      const Stopwatch watch;
      Require(window_->Add({.imu = &imu,
                            .seen = blind ? nullptr : &seen,
                            .time_offset = ToSeconds(to) - t,
                            .omega_B = omega_B}),
              "an image was refused");
      seconds_ = watch.Seconds();
      Require(window_->newest().stamp == to, "the newest state is another");
    }
  }

  // In the world of the map.
  Eigen::Matrix<double, 15, 1> Error() {
    ImuState truth = place_.scene().StateAt(ToSeconds(window_->newest().stamp));
    truth.T_WB = T_MW_ * truth.T_WB;
    return EstimateError(truth, place_.scene().bias(), window_->newest());
  }
  const VisualInertialWindow& window() const { return *window_; }
  double seconds() const { return seconds_; }  // of the window's latest Add()

 private:
  static void Require(bool ok, const char* fault) {
    if (!ok) throw std::runtime_error(fault);
  }

  MappedPlace place_;
  SinusoidalMotion motion_;
  ImuBuffer buffer_;
  std::optional<VisualInertialWindow> window_;
  Pose T_MW_;  // of the true world in that of the map
  int image_ = 0;
  double read_ = kStart, seconds_ = 0.0;
};

}  // namespace highwall::testing
