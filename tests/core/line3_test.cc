#include <highwall/core/line3.h>

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include <highwall/core/error.h>

#include "random_states.h"

namespace highwall::line3_test {
namespace {

TEST(PluckerLine, FromPointsByHand) {
  const PluckerLine line = PluckerLine::FromPoints({1, 0, 0}, {1, 0, 5});
  EXPECT_EQ(line.d, Eigen::Vector3d(0, 0, 1));
  EXPECT_EQ(line.n, Eigen::Vector3d(0, -1, 0));
  EXPECT_EQ(line.ClosestToOrigin(), Eigen::Vector3d(1, 0, 0));
  EXPECT_DOUBLE_EQ(line.Distance({1, 3, -7}), 3.0);
  EXPECT_EQ(line.Project({4, 3, -7}), Eigen::Vector3d(1, 0, -7));
}

TEST(PluckerLine, HoldsThePointsItWasMadeFrom) {
  RandomStates random(1);
  for (int i = 0; i < 50; ++i) {
    const Eigen::Vector3d p = random.Vector(5.0), q = p + random.Direction() * 0.5;
    const PluckerLine line = PluckerLine::FromPoints(p, q);
    EXPECT_LT(line.Distance(p), 1e-13);
    EXPECT_LT(line.Distance(q), 1e-13);
    EXPECT_NEAR(line.n.dot(line.d), 0.0, 1e-13);
  }
}

TEST(PluckerLine, TheLengthOfTheDirectionDoesNotMatter) {
  RandomStates random(2);
  const Eigen::Vector3d p = random.Vector(2.0), q = random.Vector(2.0), x = random.Vector(2.0);
  const PluckerLine line = PluckerLine::FromPoints(p, q);
  const PluckerLine scaled{line.n * 7.0, line.d * 7.0};
  EXPECT_TRUE(scaled.ClosestToOrigin().isApprox(line.ClosestToOrigin(), 1e-13));
  EXPECT_TRUE(scaled.Project(x).isApprox(line.Project(x), 1e-13));
}

TEST(PluckerLine, TransformsAsItsPointsDo) {
  RandomStates random(3);
  for (int i = 0; i < 50; ++i) {
    const Eigen::Vector3d p = random.Vector(5.0), q = random.Vector(5.0);
    const Pose T = random.RandomPose();
    const PluckerLine moved = T * PluckerLine::FromPoints(p, q);
    const PluckerLine expected = PluckerLine::FromPoints(T * p, T * q);
    EXPECT_TRUE(moved.n.isApprox(expected.n, 1e-12));
    EXPECT_TRUE(moved.d.isApprox(expected.d, 1e-12));
  }
}

TEST(PluckerLine, RefusesPointsThatCoincideOrAreNotFinite) {
  EXPECT_THROW(PluckerLine::FromPoints({1, 2, 3}, {1, 2, 3}), InvalidArgument);
  EXPECT_THROW(PluckerLine::FromPoints({1, 2, 3}, {1, std::numeric_limits<double>::infinity(), 3}),
               InvalidArgument);
}

TEST(OrthonormalLine, GivesThePluckerLineBack) {
  RandomStates random(4);
  for (int i = 0; i < 50; ++i) {
    const PluckerLine line = PluckerLine::FromPoints(random.Vector(5.0), random.Vector(5.0));
    const PluckerLine scaled{line.n * 3.0, line.d * 3.0};
    const PluckerLine back = OrthonormalLine(scaled).Plucker();
    EXPECT_TRUE(back.n.isApprox(line.n, 1e-12));
    EXPECT_TRUE(back.d.isApprox(line.d, 1e-12));
  }
}

TEST(OrthonormalLine, BlockIsOfUnitNorms) {
  RandomStates random(5);
  for (int i = 0; i < 50; ++i) {
    const OrthonormalLine line(PluckerLine::FromPoints(random.Vector(5.0), random.Vector(5.0)));
    EXPECT_NEAR(Eigen::Map<const Eigen::Vector4d>(line.data()).norm(), 1.0, 1e-15);
    EXPECT_NEAR(std::hypot(line.data()[4], line.data()[5]), 1.0, 1e-15);
  }
}

TEST(OrthonormalLine, DefaultIsTheZAxisShiftedAlongX) {
  const PluckerLine line = OrthonormalLine().Plucker();
  EXPECT_TRUE(line.ClosestToOrigin().isApprox(Eigen::Vector3d(1, 0, 0), 1e-15));
  EXPECT_TRUE(line.d.isApprox(Eigen::Vector3d(0, 0, 1), 1e-15));
}

TEST(OrthonormalLine, TakesALineThroughTheOrigin) {
  const Eigen::Vector3d d = Eigen::Vector3d(1, 2, 3).normalized();
  const PluckerLine line = OrthonormalLine(PluckerLine{Eigen::Vector3d::Zero(), d}).Plucker();
  EXPECT_TRUE(line.d.isApprox(d, 1e-15));
  EXPECT_LT(line.n.norm(), 1e-15);
}

TEST(OrthonormalLine, RefusesVectorsThatAreNoLine) {
  EXPECT_THROW(OrthonormalLine(PluckerLine{Eigen::Vector3d::UnitX(), Eigen::Vector3d::Zero()}),
               InvalidArgument);
  EXPECT_THROW(OrthonormalLine(
                   PluckerLine{Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN()),
                               Eigen::Vector3d::UnitX()}),
               InvalidArgument);
}

TEST(Segment3, MovesWithItsFrame) {
  RandomStates random(6);
  const Segment3 s({1, 2, 3}, {4, 6, 3});
  EXPECT_DOUBLE_EQ(s.Length(), 5.0);
  const Pose T = random.RandomPose();
  EXPECT_TRUE((T * s).p().isApprox(T * s.p(), 1e-15));
  EXPECT_TRUE((T * s).q().isApprox(T * s.q(), 1e-15));
  EXPECT_NEAR((T * s).Length(), 5.0, 1e-13);
}

TEST(Segment3, TrimToPutsTheEndsOnTheLine) {
  const PluckerLine z_axis{Eigen::Vector3d::Zero(), Eigen::Vector3d(0, 0, 2)};
  const Segment3 trimmed = TrimTo(z_axis, Segment3({1, 0, 3}, {0, -1, 5}));
  EXPECT_TRUE(trimmed.p().isApprox(Eigen::Vector3d(0, 0, 3), 1e-15));
  EXPECT_TRUE(trimmed.q().isApprox(Eigen::Vector3d(0, 0, 5), 1e-15));
}

}  // namespace
}  // namespace highwall::line3_test
