#include <highwall/frontend/calibration/allan_deviation.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include <highwall/core/error.h>

#include "support/noise_at_rest.h"

namespace highwall::allan_deviation_test {
namespace {

std::vector<AllanPoint> CurveOf(const std::vector<double>& readings, double step) {
  return AllanDeviation(std::vector<std::vector<double>>{readings}, step);
}

// A deterministic curve: that of the model, in octaves.
std::vector<AllanPoint> ModelCurve(double white, double instability, double walk) {
  const NoiseDensities densities{{white}, {instability}, {walk}};
  std::vector<AllanPoint> curve;
  for (double tau = 0.01; tau < 5000.0; tau *= 2.0) {
    curve.push_back({tau, ModelledAllanDeviation(densities, tau), 2e4 / tau});
  }
  return curve;
}

TEST(AllanDeviation, OfSixReadingsIsThatByHand) {
  // The differences of neighbours are 2, -1, 3, -4, 2: their squares sum up to 34, and half their
  // mean is 3.4. For means over two readings, 2 apart: 2.5 - 2, 2.5 - 3.5 ... integrated 0 1 4 6 11
  // 12 15.
  const auto curve = CurveOf({1, 3, 2, 5, 1, 3}, 0.5);
  ASSERT_EQ(curve.size(), 2U);
  EXPECT_EQ(curve[0].tau, 0.5);
  EXPECT_NEAR(curve[0].deviation, std::sqrt(3.4), 1e-12);
  // Pairs (1,3) (3,2) (2,5) (5,1) (1,3): sums 4 5 7 6 4; differences two apart 3, 1, -3: 19 / 3
  // / 8.
  EXPECT_EQ(curve[1].tau, 1.0);
  EXPECT_NEAR(curve[1].deviation, std::sqrt(19.0 / 24.0), 1e-12);
}

TEST(AllanDeviation, OfWhiteNoiseFallsWithTheRootOfTheTime) {
  for (const AllanPoint& point : CurveOf(NoisyReadings(1, 100'000, 100.0, 2e-3, 0.0), 0.01)) {
    if (point.freedom < 50.0) break;
    const double expected = 2e-3 / std::sqrt(point.tau);
    // 4 standard errors of a deviation.
    EXPECT_NEAR(point.deviation / expected, 1.0, 4.0 / std::sqrt(2.0 * point.freedom)) << point.tau;
  }
}

TEST(AllanDeviation, OfARandomWalkRisesWithTheRootOfTheTime) {
  for (const AllanPoint& point : CurveOf(NoisyReadings(2, 100'000, 100.0, 0.0, 3e-4), 0.01)) {
    if (point.tau < 0.1) continue;  // the discrete steps of the walk are visible
    if (point.freedom < 50.0) break;
    const double expected = 3e-4 * std::sqrt(point.tau / 3.0);
    EXPECT_NEAR(point.deviation / expected, 1.0, 4.0 / std::sqrt(2.0 * point.freedom)) << point.tau;
  }
}

TEST(AllanDeviation, ItsFreedomSaysHowFarItScatters) {
  constexpr int kSeeds = 400;
  // Returns the ratio of the measured degrees of freedom to the stated ones.
  const auto ratio = [](double white, double walk, std::size_t octave) {
    double sum = 0.0, squares = 0.0, freedom = 0.0;
    for (unsigned seed = 0; seed < kSeeds; ++seed) {
      const auto curve = CurveOf(NoisyReadings(seed, 2'000, 100.0, white, walk), 0.01);
      const double s = std::pow(curve.at(octave).deviation, 2);
      sum += s;
      squares += s * s;
      freedom = curve[octave].freedom;
    }
    const double mean = sum / kSeeds, variance = squares / kSeeds - mean * mean;
    return 2.0 * mean * mean / variance / freedom;
  };
  // 400 seeds give a variance to 10 % (one standard error). The stated freedom is the smaller of
  // that of white noise and that of a random walk, which is by a third too small where the noise is
  // white.
  EXPECT_NEAR(ratio(1e-3, 0.0, 2), 1.5, 0.3);
  EXPECT_NEAR(ratio(1e-3, 0.0, 5), 1.5, 0.3);
  EXPECT_NEAR(ratio(0.0, 1e-3, 5), 1.0, 0.3);
  EXPECT_NEAR(ratio(0.0, 1e-3, 7), 1.0, 0.3);
}

TEST(AllanDeviation, TakesNoDifferenceAcrossStretches) {
  const std::vector<double> low = NoisyReadings(3, 1'000, 100.0, 1e-3, 0.0);
  std::vector<double> high = NoisyReadings(4, 1'000, 100.0, 1e-3, 0.0);
  for (double& reading : high) reading += 5.0;
  for (const AllanPoint& point :
       AllanDeviation(std::vector<std::vector<double>>{low, high}, 0.01)) {
    EXPECT_NEAR(point.deviation * std::sqrt(point.tau) / 1e-3, 1.0,
                5.0 / std::sqrt(2.0 * point.freedom));
  }
}

TEST(AllanDeviation, IsEmptyForTooFewReadingsAndRefusesNonFiniteOnes) {
  EXPECT_TRUE(CurveOf({1.0, 2.0}, 0.01).empty());
  EXPECT_TRUE(AllanDeviation({}, 0.01).empty());
  EXPECT_THROW(CurveOf({1, 2, 3}, 0.0), InvalidArgument);
  EXPECT_THROW(CurveOf({1, std::numeric_limits<double>::quiet_NaN(), 3}, 0.01), InvalidArgument);
}

TEST(FitAllanCurve, FindsTheDensitiesOfACurveOfTheModel) {
  const NoiseDensities fit = *FitAllanCurve(ModelCurve(1.7e-4, 6e-5, 3e-6));
  // The iterations end where the relative change of the likelihood is below 1e-12.
  EXPECT_NEAR(fit.white.value, 1.7e-4, 1e-3 * 1.7e-4);
  EXPECT_NEAR(fit.instability.value, 6e-5, 1e-3 * 6e-5);
  EXPECT_NEAR(fit.walk.value, 3e-6, 1e-3 * 3e-6);
  for (const NoiseDensity& density : {fit.white, fit.instability, fit.walk}) {
    EXPECT_TRUE(density.IsSeen());
    EXPECT_LT(density.low, density.value);
    EXPECT_LT(density.value, density.high);
  }
}

TEST(FitAllanCurve, ReportsAbsentNoiseWithAnUpperBound) {
  const NoiseDensities fit = *FitAllanCurve(ModelCurve(1e-3, 0.0, 0.0));
  EXPECT_TRUE(fit.white.IsSeen());
  EXPECT_FALSE(fit.walk.IsSeen());
  EXPECT_FALSE(fit.instability.IsSeen());
  EXPECT_GT(fit.walk.high, 0.0);
  // At the longest time the walk alone would be three times the curve.
  EXPECT_LT(fit.walk.high, 3.0 * 1e-3 * std::sqrt(3.0) / 2621.44);
}

TEST(FitAllanCurve, ItsIntervalsHoldTheTruthAndAreNoWiderThanNeeded) {
  constexpr int kSeeds = 100;
  constexpr double kWhite = 2e-3, kWalk = 1e-3;
  int white = 0, walk = 0;
  std::vector<double> width;
  for (unsigned seed = 0; seed < kSeeds; ++seed) {
    const auto curve = CurveOf(NoisyReadings(seed, 30'000, 100.0, kWhite, kWalk), 0.01);
    const NoiseDensities fit = *FitAllanCurve(curve, {.model_error = 0.0});
    white += fit.white.low <= kWhite && kWhite <= fit.white.high;
    walk += fit.walk.low <= kWalk && kWalk <= fit.walk.high;
    width.push_back(fit.walk.high / std::max(fit.walk.low, 1e-9));
  }
  // 95 % of 100, with a standard error of 2.
  EXPECT_GE(white, 90);
  EXPECT_GE(walk, 90);
  std::ranges::sort(width);
  EXPECT_LT(width[kSeeds / 2], 4.0) << "300 s know the walk within a factor of 2";
}

TEST(FitAllanCurve, TooFewPointsGiveNoneAndBadOptionsAreRefused) {
  const auto curve = ModelCurve(1e-3, 0.0, 1e-4);
  EXPECT_FALSE(FitAllanCurve(std::span(curve).first(2)));
  EXPECT_FALSE(FitAllanCurve(curve, {.min_tau = 2000.0}));
  EXPECT_THROW(FitAllanCurve(curve, {.model_error = -0.1}), InvalidArgument);
}

}  // namespace
}  // namespace highwall::allan_deviation_test
