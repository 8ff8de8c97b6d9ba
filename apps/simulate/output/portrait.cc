#include "simulate/output/portrait.h"

#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

namespace highwall::simulate {

Pose PortraitPose() {
  constexpr double kHalf = std::numbers::sqrt2 / 2.0;  // a quarter about -z: x' is -y, y' is x
  return {Eigen::Quaterniond(kHalf, 0.0, 0.0, -kHalf), Eigen::Vector3d::Zero()};
}

PinholeCamera Portrait(const PinholeCamera& camera) {
  PinholeCamera turned = camera;
  turned.width = camera.height;
  turned.height = camera.width;
  turned.fx = camera.fy;
  turned.fy = camera.fx;
  turned.cx = camera.height - 1 - camera.cy;
  turned.cy = camera.cx;
  turned.p1 = camera.p2;
  turned.p2 = 0.0 - camera.p1;  // no negative zero
  return turned;
}

SimulationOptions Portrait(SimulationOptions options) {
  const Pose T_CP = PortraitPose();
  options.camera = Portrait(options.camera);
  options.imu.T_BC = options.imu.T_BC * T_CP;
  if (options.depth_camera) {
    DepthCamera& depth = *options.depth_camera;
    depth.camera = Portrait(depth.camera);
    depth.T_CD = T_CP.Inverse() * depth.T_CD * T_CP;
  }
  return options;
}

}  // namespace highwall::simulate
