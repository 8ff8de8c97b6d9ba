#pragma once

#include <cmath>
#include <random>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <highwall/core/pose.h>
#include <highwall/core/so3.h>
#include <highwall/core/stamp.h>
#include <highwall/factors/imu_buffer.h>
#include <highwall/frontend/inertial/visual_pose.h>
#include <highwall/frontend/input/sensor.h>

#include "inertial/inertial_prior.h"
#include "support/imu_scene.h"

// Common parts of the tests of inertial odometry: a body with camera and IMU on an analytic motion,
// the readings of the IMU with noise and biases, and the poses of the camera measured by images.
namespace highwall::testing {

struct InertialSceneOptions {
  double motion = 1.0;  // of SinusoidalMotion; 0: at rest
  double rest = 0.0;    // [s] stationary this long, then starts within a second; 0: it moves
  double creep = 0.0;   // [m/s] along x of W, at constant speed; with motion = 0 the only motion
  double hertz = 200.0;
  ImuNoise noise{.gyroscope = 2.44e-4,
                 .accelerometer = 1.47e-3,
                 .gyroscope_walk = 2e-5,
                 .accelerometer_walk = 1e-3};
  ImuBias bias = ImuBias::Zero();
  double time_offset = 0.0;  // [s] t_imu = t_cam + t_d
  Pose T_WN{};               // of N, whose z is up, in the frame W of the images' poses
  double position_sigma = 1e-3, rotation_sigma = 3e-4;  // [m], [rad] of the images' poses
  unsigned seed = 1;
};

class InertialScene {
 public:
  explicit InertialScene(const InertialSceneOptions& options = {})
      : options_(options), motion_(options.motion), rng_(options.seed) {}

  // Its time offset is the initial guess 0.
  ImuCalibration calibration() const {
    return {.T_BC = T_BC(), .noise = options_.noise, .rate = options_.hertz};
  }
  static Pose T_BC() { return Pose::FromTangent({0.05, -0.03, 0.08}, {-1.2, 1.2, -1.2}); }

  // Returns the readings of the IMU's [begin, end] s. Calls follow each other in time: the bias
  // walks.
  std::vector<ImuSample> Readings(double begin, double end) {
    std::vector<ImuSample> readings;
    const double step = 1.0 / options_.hertz, root = std::sqrt(options_.hertz);
    for (auto i = std::lround(begin * options_.hertz); i <= std::lround(end * options_.hertz);
         ++i) {
      ImuSample reading = SampleAt(static_cast<double>(i) * step);
      reading.gyroscope += bias().head<3>() + Noise(options_.noise.gyroscope * root);
      reading.accelerometer += bias().tail<3>() + Noise(options_.noise.accelerometer * root);
      readings.push_back(reading);
      walk_.head<3>() += Noise(options_.noise.gyroscope_walk / root);
      walk_.tail<3>() += Noise(options_.noise.accelerometer_walk / root);
    }
    return readings;
  }
  // Returns the bias at the latest reading.
  ImuBias bias() const { return options_.bias + walk_; }

  // Returns the state of the body in W at an instant of the IMU's clock [s].
  ImuState StateAt(double t_imu) const {
    const Way way = WayAt(t_imu);
    ImuState state = motion_.StateAt(way.s);
    state.v_WB *= way.rate;
    state.T_WB = options_.T_WN * state.T_WB;
    state.v_WB = options_.T_WN.q() * state.v_WB;
    const Eigen::Vector3d creep(options_.creep, 0.0, 0.0);  // not visible in the readings
    state.T_WB = Pose(state.T_WB.q(), state.T_WB.p() + t_imu * creep);
    state.v_WB += creep;
    return state;
  }
  // Returns the pose of the camera in W when an image was taken, given the stamp of the image [s].
  Pose T_WC(double t_image) const { return StateAt(t_image + options_.time_offset).T_WB * T_BC(); }
  // Returns the measured pose of an image, with the noise that it states.
  VisualPose See(double t_image) {
    const Eigen::Vector3d p = Noise(options_.position_sigma);
    const Eigen::Vector3d theta = Noise(options_.rotation_sigma);
    const Pose truth = T_WC(t_image);
    VisualPose visual;
    visual.T_WC = Pose(truth.q() * so3::Exp(-theta), truth.p() - p);
    Eigen::Matrix<double, 6, 1> sigma;
    sigma << Eigen::Vector3d::Constant(options_.position_sigma),
        Eigen::Vector3d::Constant(options_.rotation_sigma);
    visual.sqrt_information = sigma.cwiseInverse().asDiagonal();
    return visual;
  }

  Eigen::Vector3d gravity_W() const { return options_.T_WN.q() * kGravity; }

  Eigen::Vector3d Noise(double sigma) {
    std::normal_distribution<double> normal(0.0, sigma);
    const double x = normal(rng_), y = normal(rng_), z = normal(rng_);
    return {x, y, z};
  }

 private:
  // Position on the motion at an instant [s], with its rates.
  struct Way {
    double s, rate = 1.0, acceleration = 0.0;  // [s], [1], [1/s]
  };
  Way WayAt(double t) const {
    if (options_.rest <= 0.0) return {t};
    const double u = t - options_.rest;
    if (u <= 0.0) return {0.0, 0.0};
    if (u >= 1.0) return {u - 0.5};
    return {u * u * u * (1.0 - 0.5 * u), u * u * (3.0 - 2.0 * u), 6.0 * u * (1.0 - u)};
  }
  ImuSample SampleAt(double t) const {
    if (options_.rest <= 0.0) return motion_.SampleAt(FromSeconds(t));
    const Way way = WayAt(t);
    ImuSample sample = motion_.SampleAt(FromSeconds(way.s));
    sample.stamp = FromSeconds(t);
    const ImuState state = motion_.StateAt(way.s);
    const Eigen::Quaterniond q = state.T_WB.q();
    const Eigen::Vector3d a = q * sample.accelerometer + kGravity;  // along the actual motion
    sample.gyroscope *= way.rate;
    sample.accelerometer =
        q.conjugate() * (way.rate * way.rate * a + way.acceleration * state.v_WB - kGravity);
    return sample;
  }

  InertialSceneOptions options_;
  SinusoidalMotion motion_;
  std::mt19937 rng_;
  ImuBias walk_ = ImuBias::Zero();
};

// Returns [p theta | v | b_g b_a]: truth minus estimate, ordered as InertialEstimate::covariance.
inline Eigen::Matrix<double, 15, 1> EstimateError(const ImuState& truth, const ImuBias& bias,
                                                  const InertialEstimate& estimate) {
  Eigen::Matrix<double, 15, 1> error;
  error << truth.T_WB.p() - estimate.state.T_WB.p(),
      so3::Log(estimate.state.T_WB.q().conjugate() * truth.T_WB.q()),
      truth.v_WB - estimate.state.v_WB, bias - estimate.bias;
  return error;
}

// Returns the estimate moved by a step in the tangent of its covariance.
inline InertialEstimate Moved(InertialEstimate estimate, const Eigen::Matrix<double, 15, 1>& step) {
  estimate.state.T_WB = estimate.state.T_WB.Plus(step.head<6>());
  estimate.state.v_WB += step.segment<3>(6);
  estimate.bias += step.tail<6>();
  return estimate;
}

// Standard deviations of a window's start at an image's stamp [s]: [p theta v b_g b_a gravity t_d].
struct StartSigma {
  double p = 1e-3, theta = 1e-3, v = 0.02, b_g = 1e-3, b_a = 0.02, gravity = 2e-3, t_d = 2e-3;
  double T_BC = 0.0;  // [m, rad]; 0: it is known
};

// Returns a start whose error is drawn from its own covariance.
inline InertialPrior Start(InertialScene& scene, double t, double t_d, const StartSigma& sigma) {
  InertialPrior prior;
  Eigen::Matrix<double, 15, 1> s;
  s << Eigen::Vector3d::Constant(sigma.p), Eigen::Vector3d::Constant(sigma.theta),
      Eigen::Vector3d::Constant(sigma.v), Eigen::Vector3d::Constant(sigma.b_g),
      Eigen::Vector3d::Constant(sigma.b_a);
  Eigen::Matrix<double, 15, 1> step;
  for (int i = 0; i < 5; ++i) step.segment<3>(3 * i) = scene.Noise(s(3 * i));
  prior.time_offset = t_d + scene.Noise(sigma.t_d).x();
  // The state is at the instant given by the time offset of the prior.
  prior.estimate.stamp = FromSeconds(t + prior.time_offset);
  prior.estimate.state = scene.StateAt(ToSeconds(prior.estimate.stamp));
  prior.estimate.bias = scene.bias();
  prior.estimate = Moved(prior.estimate, step);
  prior.estimate.covariance = s.cwiseProduct(s).asDiagonal();
  const Eigen::Vector3d tilt = scene.Noise(sigma.gravity);
  prior.gravity_W = UnitDirection(
      Eigen::Vector3d(scene.gravity_W().normalized() + Eigen::Vector3d(tilt.x(), tilt.y(), 0.0)));
  const Eigen::Vector3d calibration(sigma.gravity, sigma.gravity, sigma.t_d);
  prior.calibration_covariance = calibration.cwiseProduct(calibration).asDiagonal();
  if (sigma.T_BC == 0.0) return prior;
  Eigen::Matrix<double, 6, 1> off;
  off << scene.Noise(sigma.T_BC), scene.Noise(sigma.T_BC);
  prior.T_BC = InertialScene::T_BC().Plus(off);
  Eigen::Matrix<double, 9, 1> all;
  all << calibration, Eigen::Matrix<double, 6, 1>::Constant(sigma.T_BC);
  prior.calibration_covariance = all.cwiseProduct(all).asDiagonal();
  prior.coupling = Eigen::Matrix<double, 15, 9>::Zero();
  return prior;
}

// Returns the angle between two vectors [rad].
inline double AngleBetween(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

}  // namespace highwall::testing
