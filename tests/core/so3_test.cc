#include <highwall/core/so3.h>

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>
#include <unsupported/Eigen/MatrixFunctions>

#include "random_states.h"

namespace highwall::so3_test {
namespace {

constexpr double kPi = std::numbers::pi;
// Values on both sides of every switch between a series and a closed form, and at the ends of the
// domain.
const double kAngles[] = {0.0, 1e-12, 1e-8, 1e-4, 0.00999, 0.01001,
                          0.1, 1.0,   2.0,  3.0,  3.14,    kPi - 1e-7};

TEST(So3, HatIsTheCrossProduct) {
  const Eigen::Vector3d v(1, 2, 3), w(-4, 5, 0.5);
  EXPECT_EQ(so3::Hat(v) * w, v.cross(w));
  EXPECT_EQ(so3::Hat(v).transpose(), -so3::Hat(v));
}

TEST(So3, ExpOfAQuarterTurnAboutZ) {
  const Eigen::Quaterniond q = so3::Exp({0, 0, 0.5 * kPi});
  EXPECT_TRUE((q * Eigen::Vector3d::UnitX()).isApprox(Eigen::Vector3d::UnitY(), 1e-15));
}

TEST(So3, ExpIsTheMatrixExponentialAndUnit) {
  RandomStates random(1);
  for (const double angle : kAngles) {
    const Eigen::Vector3d theta = random.Direction() * angle;
    const Eigen::Matrix3d expected = so3::Hat(theta).exp();
    EXPECT_TRUE(so3::Exp(theta).toRotationMatrix().isApprox(expected, 1e-14)) << angle;
    EXPECT_NEAR(so3::Exp(theta).norm(), 1.0, 1e-15) << angle;
  }
}

TEST(So3, LogInvertsExpToRounding) {
  RandomStates random(2);
  for (const double angle : kAngles) {
    for (int i = 0; i < 20; ++i) {
      const Eigen::Vector3d theta = random.Direction() * angle;
      EXPECT_LE((so3::Log(so3::Exp(theta)) - theta).norm(), 4e-15 * angle) << angle;
    }
  }
}

TEST(So3, LogOfBothSignsOfAQuaternionIsTheSame) {
  RandomStates random(3);
  for (const double angle : kAngles) {
    const Eigen::Quaterniond q = so3::Exp(random.Direction() * angle);
    const Eigen::Quaterniond minus_q(-q.coeffs());
    EXPECT_EQ(so3::Log(q), so3::Log(minus_q)) << angle;
  }
}

TEST(So3, LogOfAHalfTurnHasLengthPi) {
  EXPECT_NEAR((so3::Log(Eigen::Quaterniond(0, 0, 1, 0)) - Eigen::Vector3d(0, kPi, 0)).norm(), 0.0,
              1e-15);
}

TEST(So3, LogNeverExceedsPi) {
  RandomStates random(4);
  for (int i = 0; i < 100; ++i) {
    EXPECT_LE(so3::Log(so3::Exp(random.Direction() * random.Uniform(0.0, 20.0))).norm(),
              kPi + 1e-15);
  }
}

TEST(So3, RightJacobianMatchesCentralDifferences) {
  RandomStates random(5);
  for (const double angle : kAngles) {
    const Eigen::Vector3d theta = random.Direction() * angle;
    Eigen::Matrix3d numeric;
    const double h = 1e-5;
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d d = Eigen::Vector3d::Unit(k) * h;
      const Eigen::Quaterniond inverse = so3::Exp(theta).conjugate();
      numeric.col(k) =
          (so3::Log(inverse * so3::Exp(theta + d)) - so3::Log(inverse * so3::Exp(theta - d))) /
          (2.0 * h);
    }
    // Rounding 1e-16 / h and truncation h^2.
    EXPECT_LT((so3::RightJacobian(theta) - numeric).cwiseAbs().maxCoeff(), 2e-10) << angle;
  }
}

TEST(So3, RightJacobianTurnsItsArgumentIntoItself) {
  RandomStates random(6);
  for (const double angle : kAngles) {
    const Eigen::Vector3d theta = random.Direction() * angle;
    EXPECT_LE((so3::RightJacobian(theta) * theta - theta).norm(), 1e-14 * angle) << angle;
  }
}

TEST(So3, RightJacobianInverseIsTheInverseToRounding) {
  RandomStates random(7);
  for (const double angle : kAngles) {
    for (int i = 0; i < 20; ++i) {
      const Eigen::Vector3d theta = random.Direction() * angle;
      EXPECT_LT((so3::RightJacobian(theta) * so3::RightJacobianInverse(theta) -
                 Eigen::Matrix3d::Identity())
                    .cwiseAbs()
                    .maxCoeff(),
                2e-14)
          << angle;
    }
  }
}

}  // namespace
}  // namespace highwall::so3_test
