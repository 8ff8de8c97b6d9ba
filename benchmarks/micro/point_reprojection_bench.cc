#include <memory>

#include <highwall/factors/depth_noise.h>
#include <highwall/factors/point_reprojection.h>

#include "evaluate_bench.h"
#include "support/reprojection_twins.h"

namespace highwall::point_reprojection_bench {
namespace {

const bool registered = [] {
  const twins::Rig rig{PinholeCamera(), Pose::FromTangent({0.05, 0.0, 0.1}, {0.3, -0.5, 0.2}),
                       VirtualRightCamera()};
  const RgbdProjection projection(rig.camera, rig.T_BC, rig.right);
  const Pose T_WB = Pose::FromTangent({1.0, 2.0, 0.5}, {0.4, 1.0, -0.7});
  const Eigen::Vector3d p_W = T_WB * (rig.T_BC * Eigen::Vector3d(0.3, -0.2, 2.0));
  const std::vector<std::vector<double>> blocks = {{T_WB.data(), T_WB.data() + Pose::kSize},
                                                   {p_W.x(), p_W.y(), p_W.z()}};

  const Eigen::Vector3d z(400.0, 180.0, 20.0);
  const Eigen::Matrix2d W2 = Eigen::Matrix2d::Identity();
  const Eigen::Matrix3d W3 = PointSqrtInformation(Weighting::kCovariance, 1.0, 0.1);
  RegisterEvaluate("PointReprojection",
                   std::make_shared<PointReprojection>(z.head<2>(), W2, projection),
                   twins::MakePoint<2>({rig, z.head<2>(), W2}), blocks);
  RegisterEvaluate("PointReprojectionRgbd",
                   std::make_shared<PointReprojectionRgbd>(z, W3, projection),
                   twins::MakePoint<3>({rig, z, W3}), blocks);
  return true;
}();

}  // namespace
}  // namespace highwall::point_reprojection_bench
