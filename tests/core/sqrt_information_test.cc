#include <highwall/core/sqrt_information.h>

#include <limits>

#include <gtest/gtest.h>
#include <Eigen/LU>

#include <highwall/core/error.h>

#include "random_states.h"

namespace highwall::sqrt_information_test {
namespace {

TEST(SqrtInformation, OfADiagonalIsOneOverSigma) {
  const Eigen::Matrix2d covariance = Eigen::Vector2d(4.0, 0.01).asDiagonal();
  const Eigen::Matrix2d expected = Eigen::Vector2d(0.5, 10.0).asDiagonal();
  EXPECT_TRUE(SqrtInformation(covariance).isApprox(expected, 1e-15));
}

TEST(SqrtInformation, SquaresToTheInverseOfTheCovariance) {
  RandomStates random(1);
  for (int i = 0; i < 20; ++i) {
    const Eigen::Matrix<double, 6, 6> A = random.Matrix<6>();
    const Eigen::Matrix<double, 6, 6> S =
        A * A.transpose() + 0.1 * Eigen::Matrix<double, 6, 6>::Identity();
    const Eigen::Matrix<double, 6, 6> W = SqrtInformation(S);
    EXPECT_TRUE((W.transpose() * W).isApprox(S.inverse(), 1e-10));
    EXPECT_TRUE(W.isLowerTriangular(0.0));
  }
}

TEST(SqrtInformation, RefusesMatricesThatAreNoCovariance) {
  Eigen::Matrix2d S;
  S << 1, 2, 2, 1;
  EXPECT_THROW(SqrtInformation(S), InvalidArgument);
  S << 1, 0, 0, 0;
  EXPECT_THROW(SqrtInformation(S), InvalidArgument);
  S << 2, 1, 0, 2;
  EXPECT_THROW(SqrtInformation(S), InvalidArgument);
  S << std::numeric_limits<double>::quiet_NaN(), 0, 0, 1;
  EXPECT_THROW(SqrtInformation(S), InvalidArgument);
  EXPECT_THROW(SqrtInformation(Eigen::MatrixXd(2, 3)), InvalidArgument);
  EXPECT_THROW(SqrtInformation(Eigen::MatrixXd()), InvalidArgument);
}

}  // namespace
}  // namespace highwall::sqrt_information_test
