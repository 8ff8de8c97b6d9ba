#include "simulate/scenes/visitor.h"

#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

#include "simulate/scenes/person.h"

namespace highwall::simulate {

Pose VisitorAt(const CameraPath& path, double t) {
  const Eigen::Vector2d axes(2.05, 1.62);          // [m] of the ellipse
  constexpr double kSwing = 0.6, kInterval = 8.0;  // [rad] ahead and behind, [s]
  const Eigen::Vector3d p_WC = path.T_WC(t).p();
  const double lead = -kSwing * std::cos(2.0 * std::numbers::pi * t / kInterval);
  const double azimuth = std::atan2(p_WC.y() / axes.y(), p_WC.x() / axes.x()) + lead;
  const Eigen::Vector3d p_WB(axes.x() * std::cos(azimuth), axes.y() * std::sin(azimuth), 0.0);
  const double yaw = std::atan2(axes.y() * std::cos(azimuth), -axes.x() * std::sin(azimuth));
  return Pose(Eigen::Quaterniond(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ())), p_WB);
}

MovingScene MakeVisitor(const CameraPath& path, const std::vector<Light>& lights, double ambient) {
  return [path, lights, ambient](double t) {
    Scene scene;
    scene.lights = lights;
    scene.ambient = ambient;
    AddPerson(VisitorAt(path, t), 2.0 * std::numbers::pi * kStepsPerSecond * t, &scene);
    return scene;
  };
}

}  // namespace highwall::simulate
