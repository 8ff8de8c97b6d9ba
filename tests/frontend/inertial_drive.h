#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <vector>

#include <highwall/frontend/inertial/inertial_odometry.h>

#include "inertial_scene.h"

namespace highwall::testing {

inline constexpr double kDegree = M_PI / 180.0;
inline constexpr double kFirst = 0.2, kStep = 0.1;  // [s] stamp of the first image, interval
inline const ImuBias kBias = (ImuBias() << 0.004, -0.005, 0.003, 0.03, -0.04, 0.02).finished();
inline const Pose kTilted = Pose::FromTangent({3, -1, 2}, {0.4, -0.3, 1.3});

// Simulates an impact on the sensor that the camera does not see, between two instants [s].
inline std::function<bool(ImuSample&)> Shock(double from, double to) {
  return [=](ImuSample& reading) {
    const double t = ToSeconds(reading.stamp);
    if (t > from && t < to) {
      reading.accelerometer += Eigen::Vector3d(20.0, -30.0, 10.0);
      reading.gyroscope += Eigen::Vector3d(1.0, 2.0, -1.5);
    }
    return true;
  };
}

// Drives the odometry through a scene, image by image, as SlamSystem does.
class Drive {
 public:
  // off: error of the calibration's T_BC. accelerometer_range: of the calibration.
  explicit Drive(const InertialSceneOptions& scene_options = {},
                 const InertialOptions& options = {}, const Pose& off = Pose(),
                 double accelerometer_range = std::numeric_limits<double>::infinity())
      : scene(scene_options), odometry(Calibration(scene, off, accelerometer_range), options) {}

  // Continues until the stamp of an image is `end` [s]. sees: whether the image of a stamp has a
  // pose.
  void Until(
      double end, const std::function<bool(double)>& sees = [](double) { return true; }) {
    for (; Stamp() <= end + 1e-9; ++image_) {
      const double t = Stamp();
      for (ImuSample reading : scene.Readings(read_, t + 0.1)) Feed(reading);
      read_ = t + 0.1 + 1.0 / 200.0;
      prediction = odometry.Predict(FromSeconds(t));
      InertialOdometry::Observation observation;
      observation.image = FromSeconds(t);
      observation.sharpness = sharpness;
      observation.tracked_share = tracked_share;
      if (sees(t)) {
        observation.visual = scene.See(t);
        const Pose& seen = observation.visual->T_WC;
        observation.visual->T_WC = Pose(seen.q(), seen.p() + drift(t));
        // The map has been aligned with gravity and moved in the meantime, and the images' poses
        // with it.
        observation.visual->T_WC = T_map * observation.visual->T_WC;
      }
      reports.push_back(odometry.Update(observation));
      if (reports.back().T_gravity) {
        T_map = *reports.back().T_gravity * T_map;
        if (prediction) {
          largest_step_of_a_turn = std::max(largest_step_of_a_turn,
                                            (odometry.T_WC()->p() - prediction->T_WC.p()).norm());
        }
      }
      last = t;
    }
  }
  // Returns how often the map was aligned with gravity.
  int Levels() const {
    return static_cast<int>(std::ranges::count_if(
        reports, [](const InertialReport& r) { return r.T_gravity.has_value(); }));
  }
  double Stamp() const { return kFirst + step * image_; }
  Pose Truth(double t) const { return T_map * scene.T_WC(t); }
  double PositionError() const {
    return odometry.T_WC() ? (odometry.T_WC()->p() - Truth(last).p()).norm() : HUGE_VAL;
  }
  double AngleError() const {
    return odometry.T_WC() ? (odometry.T_WC()->Inverse() * Truth(last)).Angle() : HUGE_VAL;
  }

  InertialScene scene;
  InertialOdometry odometry;
  // Modifies a reading; returns false if the reading is missing.
  std::function<bool(ImuSample&)> change = [](ImuSample&) { return true; };
  // [m] error of the images' positions, in the frame of the scene.
  std::function<Eigen::Vector3d(double)> drift = [](double) -> Eigen::Vector3d {
    return Eigen::Vector3d::Zero();
  };
  double step = kStep;                          // [s] between images
  double sharpness = 1.0, tracked_share = 1.0;  // of the images
  Pose T_map;                                   // of the images' first frame in W
  std::vector<InertialReport> reports;
  std::optional<PoseConstraint> prediction;
  double last = 0.0;
  // [m] from the camera position predicted before a gravity alignment of the map to the position
  // after it.
  double largest_step_of_a_turn = 0.0;

 private:
  static ImuCalibration Calibration(const InertialScene& scene, const Pose& off,
                                    double accelerometer_range) {
    ImuCalibration calibration = scene.calibration();
    calibration.T_BC = calibration.T_BC * off;
    calibration.accelerometer_range = accelerometer_range;
    return calibration;
  }
  void Feed(ImuSample reading) {
    if (change(reading)) odometry.AddSample(reading);
  }
  int image_ = 0;
  double read_ = 0.0;
};

}  // namespace highwall::testing
