#include "simulate/scenes/vehicle.h"

#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include <Eigen/Geometry>

#include "simulate/random.h"

namespace highwall::simulate {
namespace {

constexpr double kBumpInterval = 0.05;  // [s] preserves most of the height of 3 Hz bumps
constexpr int kWaves = 5;               // of the driver's unsteadiness in a lap

// Sum of a few sines that repeats every lap, about +-1.
class Unsteadiness {
 public:
  explicit Unsteadiness(RandomSequence* random) {
    for (Wave& wave : waves_) {
      wave = {static_cast<double>(2 + random->Index(9)),
              random->Uniform(-std::numbers::pi, std::numbers::pi)};
    }
  }
  // lap: [0, 1].
  double At(double lap) const {
    double sum = 0.0;
    for (const Wave& wave : waves_) {
      sum += std::sin(2.0 * std::numbers::pi * wave.count * lap + wave.phase);
    }
    return sum / std::sqrt(0.5 * kWaves) / 2.0;
  }

 private:
  struct Wave {
    double count, phase;
  };
  std::array<Wave, kWaves> waves_;
};

}  // namespace

SplineTrajectory Drive(const Course& course, const RoadSurface& surface,
                       const VehicleOptions& options, std::uint64_t seed) {
  const double period = course.length() / options.speed;
  const auto knots = static_cast<int>(std::lround(period / kBumpInterval));
  RandomSequence random(Mix(seed));
  const Unsteadiness sway(&random), gaze(&random);

  const auto contact = [&](double s, double left) {
    // A tyre touches some centimetres of ground.
    constexpr double kTyre = 0.04;
    double height = 0.0;
    for (const double ahead : {-kTyre, 0.0, kTyre}) {
      height += surface.Height(s + ahead, left) / 3.0;
    }
    return course.At(s).Point(left, height);
  };
  std::vector<Pose> control;
  for (int i = 0; i < knots; ++i) {
    const double lap = static_cast<double>(i) / knots;
    const double s = lap * course.length();
    const double left = options.wander * sway.At(lap);
    const double half_base = 0.5 * options.wheelbase, half_track = 0.5 * options.track;
    const Eigen::Vector3d front_left = contact(s + half_base, left + half_track),
                          front_right = contact(s + half_base, left - half_track),
                          rear_left = contact(s - half_base, left + half_track),
                          rear_right = contact(s - half_base, left - half_track);
    const Eigen::Vector3d forward =
        (front_left + front_right - rear_left - rear_right).normalized();
    const Eigen::Vector3d across = front_left + rear_left - front_right - rear_right;
    const Eigen::Vector3d up = forward.cross(across).normalized();
    const Eigen::Vector3d middle = (front_left + front_right + rear_left + rear_right) / 4.0;

    // Camera axes x right, y down, z forward, then tilted and swayed.
    Eigen::Matrix3d R_WC;
    R_WC << forward.cross(up), -up, forward;
    const double yaw = 0.05 * gaze.At(lap);
    const Eigen::Quaterniond q_WC =
        Eigen::Quaterniond(R_WC) * Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitY()) *
        Eigen::AngleAxisd(options.camera_pitch, Eigen::Vector3d::UnitX());
    control.emplace_back(q_WC,
                         middle + options.camera_ahead * forward + options.camera_height * up);
  }
  return SplineTrajectory(std::move(control), period);
}

}  // namespace highwall::simulate
