#include <highwall/internal/se3.h>

#include <numbers>

#include <gtest/gtest.h>
#include <unsupported/Eigen/MatrixFunctions>

#include <highwall/core/so3.h>

#include "random_states.h"

namespace highwall::se3_test {
namespace {

using se3::Matrix6;
using se3::Tangent;

Tangent RandomTangent(RandomStates* random, double angle) {
  Tangent tau;
  tau << random->Vector(2.0), random->Direction() * angle;
  return tau;
}

const double kAngles[] = {0.0, 1e-9, 1e-4, 0.0099, 0.0101, 0.0999, 0.1001, 0.5, 1.5, 3.0, 3.1415};

TEST(Se3, ExpIsTheMatrixExponential) {
  RandomStates random(1);
  for (const double angle : kAngles) {
    const Tangent tau = RandomTangent(&random, angle);
    Eigen::Matrix4d twist = Eigen::Matrix4d::Zero();
    twist.topLeftCorner<3, 3>() = so3::Hat(tau.tail<3>());
    twist.topRightCorner<3, 1>() = tau.head<3>();
    EXPECT_TRUE(se3::Exp(tau).Matrix().isApprox(twist.exp(), 1e-13)) << angle;
  }
}

TEST(Se3, LogInvertsExp) {
  RandomStates random(2);
  for (const double angle : kAngles) {
    const Tangent tau = RandomTangent(&random, angle);
    EXPECT_TRUE(se3::Log(se3::Exp(tau)).isApprox(tau, 1e-12)) << angle;
  }
}

TEST(Se3, AdjointMovesAStepFromTheRightToTheLeft) {
  RandomStates random(3);
  const Pose T = random.RandomPose();
  const Tangent tau = RandomTangent(&random, 0.7);
  EXPECT_TRUE(
      (T * se3::Exp(tau)).Matrix().isApprox((se3::Exp(se3::Adjoint(T) * tau) * T).Matrix(), 1e-12));
}

TEST(Se3, RightJacobianInverseMatchesCentralDifferencesOfLog) {
  RandomStates random(4);
  for (const double angle : kAngles) {
    if (angle > 3.1) continue;  // the step would cross the jump at pi
    const Tangent tau = RandomTangent(&random, angle);
    const Pose T = se3::Exp(tau);
    Matrix6 numeric;
    const double h = 1e-6;
    for (int k = 0; k < 6; ++k) {
      const Tangent d = Tangent::Unit(k) * h;
      numeric.col(k) = (se3::Log(T * se3::Exp(d)) - se3::Log(T * se3::Exp(-d))) / (2.0 * h);
    }
    // Rounding of Log divided by the step: 1e-15 / 1e-6.
    EXPECT_LT((se3::RightJacobianInverse(tau) - numeric).cwiseAbs().maxCoeff(), 2e-8) << angle;
  }
}

TEST(Se3, RightJacobianInverseIsContinuousWhereTheSeriesTakesOver) {
  RandomStates random(5);
  const Eigen::Vector3d rho = random.Vector(2.0), axis = random.Direction();
  Tangent below, above;
  below << rho, axis * (0.1 - 1e-13);
  above << rho, axis * (0.1 + 1e-13);
  EXPECT_LT(
      (se3::RightJacobianInverse(below) - se3::RightJacobianInverse(above)).cwiseAbs().maxCoeff(),
      1e-12);
}

}  // namespace
}  // namespace highwall::se3_test
