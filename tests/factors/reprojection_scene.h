#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include <ceres/cost_function.h>
#include <ceres/manifold.h>
#include <Eigen/Core>
#include <Eigen/Geometry>

#include <highwall/core/camera.h>
#include <highwall/core/pose.h>

#include "support/reprojection_twins.h"

// Shared by the tests of the reprojection factors: a rig, random states in front of it, and the
// evaluation of a cost function.
namespace highwall {

using Block = std::vector<double>;

// Unequal focal lengths and a camera that is rotated and translated on the body, so that no
// symmetry hides an error.
inline twins::Rig TestRig() {
  const PinholeCamera camera{.fx = 520.0, .fy = 480.0, .cx = 322.5, .cy = 245.25};
  return {camera, Pose::FromTangent({0.05, -0.02, 0.1}, {0.3, -0.5, 0.2}),
          VirtualRightCamera{.fx = camera.fx, .baseline = 0.12}};
}

inline RgbdProjection Projection(const twins::Rig& rig) {
  return RgbdProjection(rig.camera, rig.T_BC, rig.right);
}

// Round numbers for values computed by hand: a camera at the body's origin, fx b = 50.
inline RgbdProjection SimpleProjection() {
  const PinholeCamera camera{.fx = 500.0, .fy = 400.0, .cx = 320.0, .cy = 240.0};
  return RgbdProjection(camera, Pose(), {.fx = 500.0, .baseline = 0.1});
}

inline double Uniform(std::mt19937& rng, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(rng);
}

inline Eigen::Vector3d RandomVector(std::mt19937& rng, double half_range) {
  const double x = Uniform(rng, -half_range, half_range);
  const double y = Uniform(rng, -half_range, half_range);
  const double z = Uniform(rng, -half_range, half_range);
  return {x, y, z};
}

// A square root of an information matrix.
inline Eigen::Matrix3d RandomWeight(std::mt19937& rng) {
  Eigen::Matrix3d W;
  W << RandomVector(rng, 3.0), RandomVector(rng, 3.0), RandomVector(rng, 3.0);
  return W;
}

// Returns a random rotation with an angle of up to pi.
inline Pose RandomPose(std::mt19937& rng) {
  const Eigen::Vector3d axis = RandomVector(rng, 1.0).normalized();
  return Pose::FromTangent(RandomVector(rng, 2.0), axis * Uniform(rng, 0.0, 3.1));
}

// Calls check(T_WB) at 50 random poses.
template <typename Check>
void AtRandomPoses(std::mt19937& rng, const Check& check) {
  for (int i = 0; i < 50; ++i) {
    SCOPED_TRACE(i);
    check(RandomPose(rng));
  }
}

// Calls check(T_WB) where a rotation vector vanishes, and where it is half a turn.
template <typename Check>
void AtEdgesOfRotation(const Check& check) {
  for (const double angle : {0.0, 1e-8, M_PI - 1e-8, M_PI}) {
    SCOPED_TRACE(angle);
    check(Pose::FromTangent({1.0, -2.0, 0.5}, Eigen::Vector3d(0.6, 0.0, 0.8) * angle));
  }
}

// Returns a point of W inside the image of the camera at T_WB, at a depth of 0.8 to 5 m.
inline Eigen::Vector3d RandomPointInView(std::mt19937& rng, const twins::Rig& rig,
                                         const Pose& T_WB) {
  const double z = Uniform(rng, 0.8, 5.0);
  const double x = Uniform(rng, -0.5, 0.5) * z, y = Uniform(rng, -0.4, 0.4) * z;
  return T_WB * (rig.T_BC * Eigen::Vector3d(x, y, z));
}

// Returns (u, v, delta) of p_W, computed from the geometry.
inline Eigen::Vector3d Observe(const twins::Rig& rig, const Pose& T_WB,
                               const Eigen::Vector3d& p_W) {
  const Eigen::Vector3d p_C = rig.ToCamera<double>(T_WB.data(), p_W);
  const Eigen::Vector2d uv = rig.Pixel<double>(p_C);
  return {uv.x(), uv.y(), rig.Disparity<double>(p_C)};
}

template <typename Value>
Block ToBlock(const Value& value) {
  return Block(value.data(), value.data() + Value::kSize);
}
inline Block ToBlock(const Eigen::Vector3d& p) {
  return {p.x(), p.y(), p.z()};
}

inline Eigen::VectorXd Residual(const ceres::CostFunction& cost, const std::vector<Block>& blocks) {
  std::vector<const double*> parameters;
  for (const Block& block : blocks) parameters.push_back(block.data());
  Eigen::VectorXd r(cost.num_residuals());
  EXPECT_TRUE(cost.Evaluate(parameters.data(), r.data(), nullptr));
  return r;
}

// Returns the Jacobians of all blocks side by side, in the tangent space of the manifolds (null:
// Euclidean).
inline Eigen::MatrixXd TangentJacobian(const ceres::CostFunction& cost,
                                       const std::vector<Block>& blocks,
                                       const std::vector<const ceres::Manifold*>& manifolds) {
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  std::vector<const double*> parameters;
  std::vector<RowMajor> ambient;
  for (const Block& block : blocks) {
    parameters.push_back(block.data());
    ambient.emplace_back(cost.num_residuals(), static_cast<Eigen::Index>(block.size()));
  }
  std::vector<double*> jacobians;
  for (RowMajor& J : ambient) jacobians.push_back(J.data());
  Eigen::VectorXd r(cost.num_residuals());
  EXPECT_TRUE(cost.Evaluate(parameters.data(), r.data(), jacobians.data()));

  Eigen::MatrixXd all(cost.num_residuals(), 0);
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    RowMajor J = ambient[i];
    if (manifolds[i] != nullptr) {
      RowMajor plus(manifolds[i]->AmbientSize(), manifolds[i]->TangentSize());
      manifolds[i]->PlusJacobian(blocks[i].data(), plus.data());
      J = ambient[i] * plus;
    }
    all.conservativeResize(Eigen::NoChange, all.cols() + J.cols());
    all.rightCols(J.cols()) = J;
  }
  return all;
}

// Expects equality to `tolerance` times the scale of the values.
inline void ExpectTwins(const ceres::CostFunction& factor, const ceres::CostFunction& twin,
                        const std::vector<Block>& blocks,
                        const std::vector<const ceres::Manifold*>& manifolds, double tolerance) {
  const Eigen::VectorXd r = Residual(factor, blocks), r_twin = Residual(twin, blocks);
  EXPECT_LT((r - r_twin).cwiseAbs().maxCoeff(), tolerance * (1.0 + r_twin.cwiseAbs().maxCoeff()));
  const Eigen::MatrixXd J = TangentJacobian(factor, blocks, manifolds);
  const Eigen::MatrixXd J_twin = TangentJacobian(twin, blocks, manifolds);
  EXPECT_LT((J - J_twin).cwiseAbs().maxCoeff(), tolerance * (1.0 + J_twin.cwiseAbs().maxCoeff()));
}

}  // namespace highwall
