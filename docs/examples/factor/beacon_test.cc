#include "beacon_range.h"

#include <array>
#include <random>

#include <gtest/gtest.h>
#include <highwall/core/testing/jacobian_check.h>

const Eigen::Vector3d kAntenna(0.3, -0.1, 0.5);

TEST(BeaconRange, JacobianMatchesCentralDifferences) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  const auto vector = [&] {
    return Eigen::Vector3d(normal(random), normal(random), normal(random));
  };
  const highwall::PoseManifold manifold;
  for (int i = 0; i < 100; ++i) {
    const highwall::Pose T_WB = highwall::Pose::FromTangent(3.0 * vector(), vector());
    const BeaconRange factor(4.0, 5.0 * vector(), kAntenna, 0.1);
    const std::vector<double> block(T_WB.data(), T_WB.data() + highwall::Pose::kSize);
    const auto check = highwall::testing::CheckJacobians(factor, {block}, {&manifold});
    EXPECT_TRUE(check) << check.message;
  }
}

TEST(BeaconRange, FindsTheBodyByFourBeacons) {
  const highwall::Pose truth = highwall::Pose::FromTangent({1.0, 2.0, 0.5}, {0.0, 0.0, 0.7});
  std::vector<Range> ranges;
  for (const highwall::Point& beacon : {highwall::Point(0, 0, 3), highwall::Point(9, 0, 1),
                                        highwall::Point(0, 9, 0), highwall::Point(9, 9, 4)}) {
    ranges.push_back({beacon, (truth * kAntenna - beacon).norm()});
  }
  const highwall::Pose prior =
      truth.Plus((Eigen::Matrix<double, 6, 1>() << 1, -2, 1, 0, 0, 0).finished());
  const highwall::Pose found = Locate(ranges, kAntenna, prior);
  // The prior, 2.4 m off and known to 10 m, pulls by (0.05 m / 10 m)^2 of its error.
  EXPECT_LT((found.p() - truth.p()).norm(), 1e-3);
}

TEST(BeaconRange, AnEchoMovesTheBodyByLessThanItsRange) {
  const highwall::Pose truth;
  std::vector<Range> ranges;
  for (const highwall::Point& beacon :
       {highwall::Point(9, 0, 1), highwall::Point(-9, 0, 0), highwall::Point(0, 9, 0),
        highwall::Point(0, -9, 2), highwall::Point(0, 0, 9)}) {
    ranges.push_back({beacon, (truth * kAntenna - beacon).norm()});
  }
  ranges[0].distance += 3.0;
  EXPECT_LT((Locate(ranges, kAntenna, truth).p() - truth.p()).norm(), 0.3);
}

TEST(BeaconRange, IsZeroAtTheBeacon) {
  const BeaconRange factor(1.0, {0, 0, 0}, {0, 0, 0}, 0.1);
  const highwall::Pose T_WB;
  const double* block = T_WB.data();
  double r = 1.0;
  std::array<double, 7> J;
  J.fill(1.0);
  double* jacobian = J.data();
  EXPECT_TRUE(factor.Evaluate(&block, &r, &jacobian));
  EXPECT_EQ(r, 0.0);
  EXPECT_EQ(J, (std::array<double, 7>{}));
  EXPECT_THROW(BeaconRange(1.0, {0, 0, 0}, {0, 0, 0}, 0.0), highwall::InvalidArgument);
}
