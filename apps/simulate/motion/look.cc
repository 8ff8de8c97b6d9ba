#include "simulate/motion/look.h"

#include <cmath>

namespace highwall::simulate {

Eigen::Quaterniond Look(double yaw, double pitch, double roll) {
  const Eigen::Vector3d z(std::cos(yaw) * std::cos(pitch), std::sin(yaw) * std::cos(pitch),
                          std::sin(pitch));
  const Eigen::Vector3d x = z.cross(Eigen::Vector3d::UnitZ()).normalized();
  Eigen::Matrix3d R_WC;
  R_WC << x, z.cross(x), z;
  return Eigen::Quaterniond(R_WC) * Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitZ());
}

}  // namespace highwall::simulate
