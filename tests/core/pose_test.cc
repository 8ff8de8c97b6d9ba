#include <highwall/core/pose.h>

#include <limits>
#include <numbers>

#include <gtest/gtest.h>

#include <highwall/core/error.h>
#include <highwall/core/so3.h>

#include "random_states.h"

namespace highwall::pose_test {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

TEST(Pose, IsStoredInTheOrderOfATumLine) {
  const Pose T(Eigen::Quaterniond(0.5, 0.5, -0.5, 0.5), {1, 2, 3});
  const std::vector<double> expected = {1, 2, 3, 0.5, -0.5, 0.5, 0.5};
  EXPECT_EQ(Block(T), expected);
  EXPECT_EQ(sizeof(Pose), 7 * sizeof(double));
}

TEST(Pose, DefaultIsTheIdentity) {
  EXPECT_EQ(Pose().Matrix(), Eigen::Matrix4d(Eigen::Matrix4d::Identity()));
  EXPECT_EQ(Block(Pose::Identity()), Block(Pose()));
}

TEST(Pose, NormalisesTheQuaternion) {
  const Pose T(Eigen::Quaterniond(0, 0, 0, 5), {0, 0, 0});
  EXPECT_EQ(T.q().z(), 1.0);
}

TEST(Pose, MapsPointsAsItsMatrixDoes) {
  RandomStates random(1);
  for (int i = 0; i < 20; ++i) {
    const Pose T = random.RandomPose();
    const Eigen::Vector3d x = random.Vector(5.0);
    const Eigen::Vector3d expected = (T.Matrix() * x.homogeneous()).head<3>();
    EXPECT_TRUE((T * x).isApprox(expected, 1e-14));
    EXPECT_TRUE((T * x).isApprox(T.R() * x + T.p(), 1e-14));
  }
}

TEST(Pose, CompositionIsTheProductOfMatrices) {
  RandomStates random(2);
  for (int i = 0; i < 20; ++i) {
    const Pose A = random.RandomPose(), B = random.RandomPose();
    EXPECT_TRUE((A * B).Matrix().isApprox(A.Matrix() * B.Matrix(), 1e-14));
  }
}

TEST(Pose, InverseUndoes) {
  RandomStates random(3);
  for (int i = 0; i < 20; ++i) {
    const Pose T = random.RandomPose();
    EXPECT_TRUE((T * T.Inverse()).Matrix().isApprox(Eigen::Matrix4d::Identity(), 1e-14));
    EXPECT_TRUE((T.Inverse() * T).Matrix().isApprox(Eigen::Matrix4d::Identity(), 1e-14));
  }
}

TEST(Pose, SurvivesConversionToMatrixAndBlock) {
  RandomStates random(4);
  for (int i = 0; i < 20; ++i) {
    const Pose T = random.RandomPose(2.0, 3.14159);
    EXPECT_TRUE(Pose::FromMatrix(T.Matrix()).Matrix().isApprox(T.Matrix(), 1e-14));
    EXPECT_TRUE(Pose::FromBlock(T.data()).Matrix().isApprox(T.Matrix(), 1e-15));
  }
}

TEST(Pose, PlusMovesPositionInTheWorldAndRotationInTheBody) {
  const Pose T = Pose::FromTangent({1, 2, 3}, {0, 0, 0.5 * std::numbers::pi});
  Eigen::Matrix<double, 6, 1> d;
  d << 0.1, 0.2, 0.3, 0.4, 0, 0;
  const Pose moved = T.Plus(d);
  EXPECT_TRUE(moved.p().isApprox(Eigen::Vector3d(1.1, 2.2, 3.3), 1e-15));
  EXPECT_TRUE(moved.R().isApprox(T.R() * so3::Exp({0.4, 0, 0}).toRotationMatrix(), 1e-15));
}

TEST(Pose, AngleIsThatOfTheShorterWay) {
  EXPECT_NEAR(Pose::FromTangent({0, 0, 0}, {0, 3.0, 0}).Angle(), 3.0, 1e-14);
  EXPECT_NEAR(Pose::FromTangent({0, 0, 0}, {0, 4.0, 0}).Angle(), 2.0 * std::numbers::pi - 4.0,
              1e-14);
  EXPECT_NEAR(Pose::FromTangent({0, 0, 0}, {1e-9, 0, 0}).Angle(), 1e-9, 1e-23);
}

TEST(Pose, RefusesMatricesThatAreNoPose) {
  EXPECT_THROW(Pose(Eigen::Quaterniond(0, 0, 0, 0), {0, 0, 0}), InvalidArgument);
  EXPECT_THROW(Pose(Eigen::Quaterniond(kNaN, 0, 0, 1), {0, 0, 0}), InvalidArgument);
  EXPECT_THROW(Pose(Eigen::Quaterniond::Identity(), {0, kNaN, 0}), InvalidArgument);
  EXPECT_THROW(Pose::FromMatrix(Eigen::Matrix4d::Constant(kNaN)), InvalidArgument);
  EXPECT_THROW(Pose::FromMatrix(Eigen::Vector4d(1, 1, -1, 1).asDiagonal().toDenseMatrix()),
               InvalidArgument);
  EXPECT_THROW(Pose::FromMatrix(2.0 * Eigen::Matrix4d::Identity()), InvalidArgument);
}

TEST(Pose, KnowsWhetherItIsFinite) {
  Pose T;
  EXPECT_TRUE(T.IsFinite());
  T.data()[4] = kNaN;
  EXPECT_FALSE(T.IsFinite());
}

}  // namespace
}  // namespace highwall::pose_test
