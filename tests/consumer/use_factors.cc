// Uses factors: evaluates a reprojection at its own measurement; exits 0 if it is zero.
#include <Eigen/Core>

#include <highwall/core/camera.h>
#include <highwall/core/pose.h>
#include <highwall/factors/point_reprojection.h>

int main() {
  using namespace highwall;
  const PinholeCamera camera;
  const Eigen::Vector3d p_W(0.5, -0.25, 2.0);
  const PointReprojection factor(camera.Project(p_W), Eigen::Matrix2d::Identity(),
                                 RgbdProjection(camera, Pose()));
  const Pose T_WB;
  const double* blocks[] = {T_WB.data(), p_W.data()};
  Eigen::Vector2d r;
  return factor.Evaluate(blocks, r.data(), nullptr) && r.norm() < 1e-9 ? 0 : 1;
}
