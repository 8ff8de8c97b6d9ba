#include <memory>

#include <highwall/factors/camera_pose.h>
#include <highwall/factors/scaled_motion.h>

#include "evaluate_bench.h"
#include "support/calibration_twins.h"

namespace highwall::calibration_bench {
namespace {

void RegisterCameraPose() {
  const Pose T_WC_0 = Pose::FromTangent({1.0, 2.0, 0.5}, {0.4, 1.0, -0.7});
  const Pose T_BC = Pose::FromTangent({0.05, 0.0, 0.1}, {0.3, -0.5, 0.2});
  const Pose T_WB = Pose::FromTangent({0.9, 2.1, 0.5}, {0.1, 1.2, -0.8});
  const Eigen::Matrix<double, 6, 6> W = 2.0 * Eigen::Matrix<double, 6, 6>::Identity();
  const Eigen::Vector3d omega_B(0.1, -0.2, 0.3);
  RegisterEvaluate("CameraPose", std::make_shared<CameraPose>(T_WC_0, W, T_BC, omega_B, 0.01),
                   twins::MakeCameraPose({T_WC_0, W, T_BC, omega_B, 0.01}),
                   {{T_WB.data(), T_WB.data() + Pose::kSize}, {1.0, 0.5, -0.2}, {0.02}});
}

void RegisterScaledMotion() {
  const Pose Z = Pose::FromTangent({0.3, -0.1, 0.2}, {0.1, 0.2, -0.05});
  const Pose T_BC = Pose::FromTangent({0.05, 0.0, 0.1}, {0.3, -0.5, 0.2});
  const Pose T_i = Pose::FromTangent({0.9, 2.1, 0.5}, {0.1, 1.2, -0.8});
  const Pose T_j = Pose::FromTangent({1.2, 2.0, 0.7}, {0.2, 1.1, -0.7});
  const Eigen::Matrix<double, 6, 6> W = 2.0 * Eigen::Matrix<double, 6, 6>::Identity();
  RegisterEvaluate(
      "ScaledMotion", std::make_shared<ScaledMotion>(Z, W, T_BC),
      twins::MakeScaledMotion({Z, W, T_BC}),
      {{T_i.data(), T_i.data() + Pose::kSize}, {T_j.data(), T_j.data() + Pose::kSize}, {0.98}});
}

const bool registered = [] {
  RegisterCameraPose();
  RegisterScaledMotion();
  return true;
}();

}  // namespace
}  // namespace highwall::calibration_bench
