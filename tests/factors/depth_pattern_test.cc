#include <highwall/factors/depth_pattern.h>

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include <highwall/core/error.h>

namespace highwall::depth_pattern_test {
namespace {

constexpr int kWidth = 641, kHeight = 481;  // nodes every 160 pixels

double At(const DepthPattern& pattern, double u, double v) {
  return pattern.At(u, v, kWidth, kHeight);
}

DepthPattern Numbered() {
  DepthPattern pattern;
  for (int i = 0; i < DepthPattern::kNodes; ++i) pattern.nodes[i] = 0.01 * i;
  return pattern;
}

TEST(DepthPattern, HasItsNodesWhereTheyLie) {
  const DepthPattern pattern = Numbered();
  EXPECT_FALSE(pattern.IsZero());
  EXPECT_TRUE(DepthPattern().IsZero());
  for (int row = 0; row < DepthPattern::kRows; ++row) {
    for (int column = 0; column < DepthPattern::kColumns; ++column) {
      EXPECT_NEAR(At(pattern, 160.0 * column, 160.0 * row),
                  0.01 * (row * DepthPattern::kColumns + column), 1e-15);
    }
  }
}

TEST(DepthPattern, IsBilinearBetweenItsNodes) {
  // A bilinear function of the pixel is reproduced everywhere, not only at the nodes.
  const auto plane = [](double u, double v) { return 1e-3 + 2e-5 * u - 3e-5 * v + 4e-8 * u * v; };
  DepthPattern pattern;
  for (int row = 0; row < DepthPattern::kRows; ++row) {
    for (int column = 0; column < DepthPattern::kColumns; ++column) {
      pattern.nodes[row * DepthPattern::kColumns + column] = plane(160.0 * column, 160.0 * row);
    }
  }
  std::mt19937 rng(1);
  std::uniform_real_distribution<double> u(0.0, kWidth - 1.0), v(0.0, kHeight - 1.0);
  for (int i = 0; i < 100; ++i) {
    const double x = u(rng), y = v(rng);
    const DepthPattern::Vector shares = DepthPattern::Shares(x, y, kWidth, kHeight);
    EXPECT_NEAR(shares.sum(), 1.0, 1e-15);
    EXPECT_GE(shares.minCoeff(), 0.0);
    EXPECT_NEAR(shares.dot(pattern.nodes), plane(x, y), 1e-15);  // for numbers of about 0.01
    EXPECT_NEAR(At(pattern, x, y), plane(x, y), 1e-15);
  }
}

TEST(DepthPattern, BeyondTheImageIsAsAtItsEdge) {
  const DepthPattern pattern = Numbered();
  EXPECT_EQ(At(pattern, -30.0, -1.0), At(pattern, 0.0, 0.0));
  EXPECT_EQ(At(pattern, 1000.0, 1000.0), At(pattern, kWidth - 1.0, kHeight - 1.0));
}

TEST(DepthPattern, RefusesNodesThatAreNone) {
  for (const double bad : {1.0, -2.0, std::nan("")}) {
    DepthPattern pattern;
    pattern.nodes[3] = bad;
    EXPECT_THROW(pattern.Validate(), InvalidArgument) << bad;
  }
  EXPECT_NO_THROW(Numbered().Validate());
}

}  // namespace
}  // namespace highwall::depth_pattern_test
