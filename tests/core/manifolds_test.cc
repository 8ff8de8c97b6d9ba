#include <highwall/core/manifolds.h>

#include <cmath>

#include <ceres/manifold_test_utils.h>
#include <gtest/gtest.h>

#include <highwall/core/error.h>
#include <highwall/core/line3.h>
#include <highwall/core/pose.h>
#include <highwall/core/so3.h>

#include "random_states.h"

namespace highwall::manifolds_test {
namespace {

constexpr double kTolerance = 1e-9;  // for differences of 1e-16 over steps down to 1e-5

Eigen::VectorXd Step(RandomStates* random, int size, double length) {
  Eigen::VectorXd d(size);
  for (int i = 0; i < size; ++i) d[i] = random->Uniform(-1.0, 1.0);
  return d.normalized() * length;
}

void ExpectInvariants(const ceres::Manifold& manifold, const Eigen::VectorXd& x,
                      const Eigen::VectorXd& delta) {
  using namespace ceres;  // the macro uses names of matchers without qualification
  Eigen::VectorXd y(manifold.AmbientSize());
  ASSERT_TRUE(manifold.Plus(x.data(), delta.data(), y.data()));
  EXPECT_THAT_MANIFOLD_INVARIANTS_HOLD(manifold, x, delta, y, kTolerance);
}

Eigen::VectorXd RandomLineBlock(RandomStates* random) {
  const OrthonormalLine line(PluckerLine::FromPoints(random->Vector(3.0), random->Vector(3.0)));
  return Eigen::Map<const Eigen::VectorXd>(line.data(), OrthonormalLine::kSize);
}

TEST(PoseManifold, HoldsCeresInvariants) {
  RandomStates random(1);
  for (const double length : {0.0, 1e-5, 1e-3, 0.5, 2.0}) {
    for (int i = 0; i < 10; ++i) {
      const Pose T = random.RandomPose();
      ExpectInvariants(PoseManifold(), Eigen::Map<const Eigen::VectorXd>(T.data(), 7),
                       Step(&random, 6, length));
    }
  }
}

TEST(PoseManifold, PlusIsThePlusOfPose) {
  RandomStates random(2);
  const Pose T = random.RandomPose();
  const Eigen::Matrix<double, 6, 1> d = Step(&random, 6, 1.0);
  Pose moved;
  ASSERT_TRUE(PoseManifold().Plus(T.data(), d.data(), moved.data()));
  EXPECT_TRUE(moved.Matrix().isApprox(T.Plus(d).Matrix(), 1e-15));
}

TEST(PoseManifold, StaysUnitOverManySteps) {
  RandomStates random(3);
  Pose T = random.RandomPose();
  for (int i = 0; i < 100000; ++i) {
    const double d[6] = {0, 0, 0, 0.01, -0.02, 0.03};
    PoseManifold().Plus(T.data(), d, T.data());
  }
  EXPECT_NEAR(T.q().norm(), 1.0, 1e-15);
}

TEST(PoseManifold, LiftedJacobiansComeBackThroughPlusJacobian) {
  RandomStates random(4);
  for (int i = 0; i < 20; ++i) {
    const Pose T = random.RandomPose();
    const Eigen::Matrix<double, 6, 6> J = random.Matrix<6>();
    Eigen::Matrix<double, 6, 7, Eigen::RowMajor> lifted;
    Eigen::Matrix<double, 7, 6, Eigen::RowMajor> plus;
    PoseManifold::Lift<6>(T.data(), J, lifted.data());
    PoseManifold().PlusJacobian(T.data(), plus.data());
    EXPECT_TRUE((lifted * plus).isApprox(J, 1e-14));
  }
}

TEST(PoseManifold, MinusOfTheOtherSignOfAQuaternionIsZero) {
  RandomStates random(5);
  const Pose T = random.RandomPose();
  Pose other = T;
  for (int i = 3; i < 7; ++i) other.data()[i] *= -1.0;
  Eigen::Matrix<double, 6, 1> d;
  PoseManifold().Minus(other.data(), T.data(), d.data());
  EXPECT_LT(d.norm(), 1e-15);
}

TEST(LineManifold, HoldsCeresInvariants) {
  RandomStates random(6);
  for (const double length : {0.0, 1e-5, 1e-3, 0.5, 2.0}) {
    for (int i = 0; i < 10; ++i) {
      ExpectInvariants(LineManifold(), RandomLineBlock(&random), Step(&random, 4, length));
    }
  }
}

TEST(LineManifold, LiftedJacobiansComeBackThroughPlusJacobian) {
  RandomStates random(7);
  for (int i = 0; i < 20; ++i) {
    const Eigen::VectorXd x = RandomLineBlock(&random);
    const Eigen::Matrix4d J = random.Matrix<4>();
    Eigen::Matrix<double, 4, 6, Eigen::RowMajor> lifted;
    Eigen::Matrix<double, 6, 4, Eigen::RowMajor> plus;
    LineManifold::Lift<4>(x.data(), J, lifted.data());
    LineManifold().PlusJacobian(x.data(), plus.data());
    EXPECT_TRUE((lifted * plus).isApprox(J, 1e-14));
  }
}

TEST(LineManifold, TheFourthCoordinateMovesTheLineAwayFromTheOrigin) {
  // w = (|n|, |d|) normalised = (sin a, cos a) for a line at distance tan a: dphi rotates it.
  const OrthonormalLine line(PluckerLine::FromPoints({1, 0, 0}, {1, 0, 1}));
  const double d[4] = {0, 0, 0, 0.1};
  OrthonormalLine moved;
  ASSERT_TRUE(LineManifold().Plus(line.data(), d, moved.data()));
  // [w_1 -w_2; w_2 w_1] R2(dphi): atan2(w_2, w_1) grows by dphi, so the distance shrinks.
  EXPECT_NEAR(moved.Plucker().n.norm(), 1.0 / std::tan(0.25 * M_PI + 0.1), 1e-14);
  EXPECT_TRUE(moved.Plucker().d.isApprox(line.Plucker().d, 1e-14));
}

TEST(LineManifold, ARotationOfUMovesTheLineAsARotationOfSpaceDoes) {
  RandomStates random(8);
  const OrthonormalLine line(PluckerLine::FromPoints(random.Vector(3.0), random.Vector(3.0)));
  const Eigen::Vector3d dtheta = random.Vector(0.5);
  Eigen::Vector4d d;
  d << dtheta, 0.0;
  OrthonormalLine moved;
  ASSERT_TRUE(LineManifold().Plus(line.data(), d.data(), moved.data()));
  // U Exp(dtheta) = Exp(U dtheta) U.
  const Eigen::Matrix3d U = Eigen::Map<const Eigen::Quaterniond>(line.data()).toRotationMatrix();
  const PluckerLine expected =
      Pose::FromTangent(Eigen::Vector3d::Zero(), U * dtheta) * line.Plucker();
  EXPECT_TRUE(moved.Plucker().n.isApprox(expected.n, 1e-12));
  EXPECT_TRUE(moved.Plucker().d.isApprox(expected.d, 1e-12));
}

TEST(UnitDirectionManifold, HoldsCeresInvariants) {
  RandomStates random(9);
  for (const double length : {0.0, 1e-5, 1e-3, 0.5, 2.0, 3.1}) {
    for (int i = 0; i < 10; ++i) {
      ExpectInvariants(UnitDirectionManifold(), random.Direction(), Step(&random, 2, length));
    }
    ExpectInvariants(UnitDirectionManifold(), -Eigen::Vector3d::UnitZ(), Step(&random, 2, length));
    ExpectInvariants(UnitDirectionManifold(), Eigen::Vector3d::UnitX(), Step(&random, 2, length));
  }
}

TEST(UnitDirectionManifold, AStepIsAnAngleAlongAGreatCircle) {
  RandomStates random(10);
  for (int i = 0; i < 20; ++i) {
    const UnitDirection n(random.Direction());
    const Eigen::Vector2d d = Step(&random, 2, 0.7);
    UnitDirection moved;
    ASSERT_TRUE(UnitDirectionManifold().Plus(n.data(), d.data(), moved.data()));
    EXPECT_NEAR(moved.vector().norm(), 1.0, 1e-15);
    EXPECT_NEAR(n.vector().dot(moved.vector()), std::cos(0.7), 1e-14);
  }
}

TEST(UnitDirectionManifold, BasisIsOrthonormalEverywhere) {
  RandomStates random(11);
  for (int i = 0; i < 50; ++i) {
    const Eigen::Vector3d n = i == 0 ? Eigen::Vector3d(0, 0, -1) : random.Direction();
    Eigen::Matrix3d frame;
    frame << UnitDirectionManifold::Basis(n.data()), n;
    EXPECT_TRUE((frame.transpose() * frame).isIdentity(1e-14)) << n.transpose();
  }
}

TEST(UnitDirectionManifold, LiftedJacobiansComeBackThroughPlusJacobian) {
  RandomStates random(12);
  const Eigen::Vector3d n = random.Direction();
  const Eigen::Matrix2d J = random.Matrix<2>();
  Eigen::Matrix<double, 2, 3, Eigen::RowMajor> lifted;
  Eigen::Matrix<double, 3, 2, Eigen::RowMajor> plus;
  UnitDirectionManifold::Lift<2>(n.data(), J, lifted.data());
  UnitDirectionManifold().PlusJacobian(n.data(), plus.data());
  EXPECT_TRUE((lifted * plus).isApprox(J, 1e-14));
}

TEST(UnitDirectionManifold, OppositeDirectionsAreHalfATurnApart) {
  const Eigen::Vector3d n(0, 0, 1), m(0, 0, -1);
  Eigen::Vector2d d;
  ASSERT_TRUE(UnitDirectionManifold().Minus(m.data(), n.data(), d.data()));
  EXPECT_NEAR(d.norm(), M_PI, 1e-15);
}

TEST(UnitDirection, IsNormalisedAndPointsDownByDefault) {
  EXPECT_EQ(UnitDirection().vector(), Eigen::Vector3d(0, 0, -1));
  EXPECT_TRUE(UnitDirection({3, 0, 4}).vector().isApprox(Eigen::Vector3d(0.6, 0, 0.8), 1e-15));
  EXPECT_THROW(UnitDirection({0, 0, 0}), InvalidArgument);
  EXPECT_THROW(UnitDirection({NAN, 0, 1}), InvalidArgument);
}

}  // namespace
}  // namespace highwall::manifolds_test
