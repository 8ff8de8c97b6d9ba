#include <memory>

#include <highwall/factors/camera_pose.h>
#include <highwall/factors/extrinsic_reprojection.h>
#include <highwall/factors/scaled_motion.h>
#include <highwall/factors/time_offset_reprojection.h>

#include "evaluate_bench.h"
#include "support/calibration_twins.h"

namespace highwall::calibration_bench {
namespace {

template <int kRows>
void Register(const std::string& suffix) {
  const twins::Rig rig{PinholeCamera(), Pose::FromTangent({0.05, 0.0, 0.1}, {0.3, -0.5, 0.2}),
                       VirtualRightCamera()};
  const RgbdProjection projection(rig.camera, rig.T_BC, rig.right);
  const Pose T_WB = Pose::FromTangent({1.0, 2.0, 0.5}, {0.4, 1.0, -0.7});
  const Eigen::Vector3d p_W = T_WB * (rig.T_BC * Eigen::Vector3d(0.3, -0.2, 2.0));
  using Vector = Eigen::Matrix<double, kRows, 1>;
  const Vector z = Eigen::Vector3d(400.0, 180.0, 20.0).head<kRows>();
  const Vector velocity = Eigen::Vector3d(50.0, -20.0, 1.0).head<kRows>();
  const Eigen::Matrix<double, kRows, kRows> W = Eigen::Matrix<double, kRows, kRows>::Identity();
  const std::vector<double> pose(T_WB.data(), T_WB.data() + Pose::kSize);
  const std::vector<double> point(p_W.data(), p_W.data() + 3);

  RegisterEvaluate(
      "PointReprojection" + suffix + "TimeOffset",
      std::make_shared<TimeOffsetReprojection<kRows>>(z, velocity, W, projection, 0.01),
      twins::MakeTimeOffset<kRows>({{rig, z, W}, velocity, 0.01}), {pose, point, {0.02}});
  RegisterEvaluate("PointReprojection" + suffix + "Extrinsics",
                   std::make_shared<ExtrinsicReprojection<kRows>>(z, W, projection),
                   twins::MakeExtrinsics<kRows>({{rig, z, W}}),
                   {pose, point, {rig.T_BC.data(), rig.T_BC.data() + Pose::kSize}});
}

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
  Register<2>("");
  Register<3>("Rgbd");
  RegisterCameraPose();
  RegisterScaledMotion();
  return true;
}();

}  // namespace
}  // namespace highwall::calibration_bench
