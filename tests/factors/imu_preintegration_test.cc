#include <highwall/factors/imu_preintegration.h>

#include <cmath>
#include <cstdlib>
#include <limits>
#include <new>
#include <random>

#include <gtest/gtest.h>
#include <Eigen/Eigenvalues>

#include <highwall/core/error.h>

#include "support/imu_scene.h"

namespace {
std::size_t allocations = 0;
}  // namespace

// Counts the heap allocations of this binary. All forms with which a call of another form may be
// paired are replaced, since std::stable_sort allocates by the one that does not throw.
[[gnu::noinline]] void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  ++allocations;
  return std::malloc(size);
}
[[gnu::noinline]] void* operator new(std::size_t size) {
  if (void* p = operator new(size, std::nothrow)) return p;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* p) noexcept {
  std::free(p);
}
[[gnu::noinline]] void operator delete(void* p, const std::nothrow_t&) noexcept {
  std::free(p);
}
[[gnu::noinline]] void operator delete(void* p, std::size_t) noexcept {
  std::free(p);
}

namespace highwall::imu_preintegration_test {
namespace {

using Vector9 = Eigen::Matrix<double, 9, 1>;
using Matrix15 = Eigen::Matrix<double, 15, 15>;

const double kNan = std::numeric_limits<double>::quiet_NaN();

ImuBias TestBias() {
  return (ImuBias() << 0.02, -0.03, 0.01, 0.1, -0.2, 0.15).finished();
}

// Returns the largest error of the predicted state over `duration`.
double PredictionError(const SinusoidalMotion& motion, double hertz, double duration) {
  const auto samples = motion.Samples(hertz, duration);
  const ImuPreintegration imu(samples, ImuBias::Zero());
  const ImuState predicted = imu.Predict(motion.StateAt(0.0), ImuBias::Zero(), kGravity);
  return StateDifference(motion.StateAt(duration), predicted).cwiseAbs().maxCoeff();
}

TEST(ImuPreintegration, AtRestOnlyGravityIsFelt) {
  std::vector<ImuSample> samples;
  for (int i = 0; i <= 200; ++i) {
    samples.push_back({i * 5'000'000, Eigen::Vector3d::Zero(), {0.0, 0.0, 9.81}});
  }
  const ImuPreintegration imu(samples, ImuBias::Zero());
  EXPECT_NEAR(imu.delta().duration, 1.0, 1e-14);
  EXPECT_EQ(imu.delta().q.angularDistance(Eigen::Quaterniond::Identity()), 0.0);
  EXPECT_LT((imu.delta().v - Eigen::Vector3d(0, 0, 9.81)).norm(), 1e-13);
  EXPECT_LT((imu.delta().p - Eigen::Vector3d(0, 0, 4.905)).norm(), 1e-13);
  const ImuState rest{Pose::FromTangent({1, 2, 3}, {0, 0, 0.7}), Eigen::Vector3d::Zero()};
  EXPECT_LT(StateDifference(rest, imu.Predict(rest, ImuBias::Zero(), kGravity)).norm(), 1e-13);
}

TEST(ImuPreintegration, FollowsACircleAtConstantSpeed) {
  // Radius 2 m at 0.5 rad/s: the body measures a constant rate and a constant centripetal
  // acceleration.
  constexpr double kRate = 0.5, kRadius = 2.0;
  std::vector<ImuSample> samples;
  for (int i = 0; i <= 400; ++i) {
    samples.push_back({i * 5'000'000, {0, 0, kRate}, {-kRate * kRate * kRadius, 0.0, 9.81}});
  }
  const ImuPreintegration imu(samples, ImuBias::Zero());
  const ImuState start{Pose::FromTangent({kRadius, 0, 0}, {0, 0, 0}), {0, kRate * kRadius, 0}};
  const ImuState end = imu.Predict(start, ImuBias::Zero(), kGravity);
  const double a = kRate * 2.0;
  // 400 steps of fourth order, each with a rotation of 2.5e-3 rad.
  EXPECT_LT((end.T_WB.p() - kRadius * Eigen::Vector3d(std::cos(a), std::sin(a), 0)).norm(), 1e-12);
  EXPECT_LT((end.v_WB - kRadius * kRate * Eigen::Vector3d(-std::sin(a), std::cos(a), 0)).norm(),
            1e-12);
}

TEST(ImuPreintegration, PredictsAnAnalyticMotionToANanometreAtOneKilohertz) {
  EXPECT_LT(PredictionError(SinusoidalMotion(), 1000.0, 0.5), 1e-9);
  EXPECT_LT(PredictionError(SinusoidalMotion(), 1000.0, 2.0), 1e-9);
}

TEST(ImuPreintegration, ConvergesWithTheFourthOrder) {
  const SinusoidalMotion motion(2.0);
  double previous = PredictionError(motion, 100.0, 1.0);
  for (const double hertz : {200.0, 400.0, 800.0}) {
    const double error = PredictionError(motion, hertz, 1.0);
    EXPECT_NEAR(std::log2(previous / error), 4.0, 0.35) << hertz;
    previous = error;
  }
  EXPECT_LT(PredictionError(motion, 200.0, 1.0), 5e-6);
}

TEST(ImuPreintegration, UnevenStepsKeepTheAccuracy) {
  const SinusoidalMotion motion;
  std::mt19937 rng(3);
  std::uniform_int_distribution<Stamp> jitter(-150'000, 150'000);
  std::vector<ImuSample> samples;
  for (int i = 0; i <= 500; ++i) {
    const bool end = i == 0 || i == 500;
    samples.push_back(motion.SampleAt(i * 1'000'000 + (end ? 0 : jitter(rng))));
  }
  const ImuPreintegration imu(samples, ImuBias::Zero());
  const ImuState predicted = imu.Predict(motion.StateAt(0.0), ImuBias::Zero(), kGravity);
  EXPECT_LT(StateDifference(motion.StateAt(0.5), predicted).cwiseAbs().maxCoeff(), 5e-9);
}

TEST(ImuPreintegration, TheBiasItIsGivenIsTakenOff) {
  const SinusoidalMotion motion;
  const auto clean = motion.Samples(200.0, 0.5);
  const ImuPreintegration with(WithBias(clean, TestBias()), TestBias());
  const ImuPreintegration without(clean, ImuBias::Zero());
  EXPECT_LT(with.delta().q.angularDistance(without.delta().q), 1e-13);
  EXPECT_LT((with.delta().v - without.delta().v).norm(), 1e-13);
  EXPECT_LT((with.delta().p - without.delta().p).norm(), 1e-13);
}

// Returns [theta v p] of b relative to a.
Vector9 Difference(const ImuDelta::Motion& a, const ImuDelta::Motion& b) {
  Vector9 d;
  d << so3::Log(a.q.conjugate() * b.q), b.v - a.v, b.p - a.p;
  return d;
}

TEST(ImuPreintegration, BiasJacobianMatchesIntegratingAgain) {
  const auto samples = SinusoidalMotion(2.0).Samples(200.0, 0.5);
  const ImuPreintegration imu(samples, TestBias());
  const ImuDelta::Motion base = imu.delta().At(TestBias());
  Eigen::Matrix<double, 9, 6> numeric;
  constexpr double kStep = 1e-5;
  for (int i = 0; i < 6; ++i) {
    const ImuBias d = kStep * ImuBias::Unit(i);
    const ImuDelta plus = imu.Reintegrated(TestBias() + d).delta();
    const ImuDelta minus = imu.Reintegrated(TestBias() - d).delta();
    numeric.col(i) =
        (Difference(base, plus.At(plus.bias)) - Difference(base, minus.At(minus.bias))) /
        (2.0 * kStep);
  }
  // The error of the Jacobian is of second order in the step: (w h)^2 / 6 = 5e-5 at 3.5 rad/s and 5
  // ms.
  for (int block = 0; block < 3; ++block) {
    const auto J = imu.delta().bias_jacobian.middleRows<3>(3 * block);
    const auto N = numeric.middleRows<3>(3 * block);
    EXPECT_LT((J - N).cwiseAbs().maxCoeff(), 5e-5 * N.cwiseAbs().maxCoeff()) << J << "\n\n" << N;
  }
}

TEST(ImuPreintegration, FirstOrderCorrectionLeavesAnErrorOfSecondOrder) {
  const auto samples = SinusoidalMotion().Samples(1000.0, 0.5);
  const ImuPreintegration imu(samples, ImuBias::Zero());
  const ImuBias direction = TestBias() / TestBias().norm();
  double previous = 0.0;
  for (const double size : {0.2, 0.1, 0.05}) {
    const ImuDelta exact = imu.Reintegrated(size * direction).delta();
    const double error = Difference(exact.At(exact.bias), imu.delta().At(size * direction)).norm();
    if (previous > 0.0) {
      EXPECT_NEAR(std::log2(previous / error), 2.0, 0.15) << size;
    }
    previous = error;
  }
}

TEST(ImuPreintegration, AsksForReintegrationOnceTheBiasIsFar) {
  const ImuPreintegrationOptions options{.max_gyroscope_change = 0.01,
                                         .max_accelerometer_change = 0.1};
  const ImuPreintegration imu(SinusoidalMotion().Samples(200.0, 0.5), TestBias(), options);
  const auto moved = [](double gyroscope, double accelerometer) {
    ImuBias bias = TestBias();
    bias(1) += gyroscope;
    bias(5) += accelerometer;
    return bias;
  };
  EXPECT_FALSE(imu.NeedsReintegration(TestBias()));
  EXPECT_FALSE(imu.NeedsReintegration(moved(0.009, -0.09)));
  EXPECT_TRUE(imu.NeedsReintegration(moved(-0.011, 0.0)));
  EXPECT_TRUE(imu.NeedsReintegration(moved(0.0, 0.11)));
  EXPECT_TRUE(imu.NeedsReintegration(moved(kNan, 0.0)));
  const ImuPreintegration again = imu.Reintegrated(moved(0.02, 0.0));
  EXPECT_EQ(again.delta().bias, moved(0.02, 0.0));
  EXPECT_FALSE(again.NeedsReintegration(moved(0.02, 0.0)));
  EXPECT_EQ(again.start(), imu.start());
  EXPECT_EQ(again.end(), imu.end());
}

TEST(ImuPreintegration, JoinedIntervalsAreTheSameAsOne) {
  const auto samples = SinusoidalMotion(2.0).Samples(200.0, 1.0);
  const ImuPreintegrationOptions options{.noise = {.gyroscope = 2e-3, .accelerometer = 2e-2}};
  const std::span<const ImuSample> all = samples;
  const ImuPreintegration whole(all, TestBias(), options);
  // The next interval may be preintegrated with another bias: only its readings matter.
  const ImuPreintegration first(all.first(81), TestBias(), options);
  const ImuPreintegration next(all.subspan(80), ImuBias::Zero(), options);
  const ImuPreintegration joined = first.Joined(next);
  EXPECT_EQ(joined.start(), whole.start());
  EXPECT_EQ(joined.end(), whole.end());
  EXPECT_EQ(joined.samples().size(), whole.samples().size());
  // The same readings are integrated in the same order, so the results are bit-identical.
  EXPECT_EQ(joined.delta().bias, whole.delta().bias);
  EXPECT_EQ(joined.delta().duration, whole.delta().duration);
  EXPECT_EQ(joined.delta().q.coeffs(), whole.delta().q.coeffs());
  EXPECT_EQ(joined.delta().v, whole.delta().v);
  EXPECT_EQ(joined.delta().p, whole.delta().p);
  EXPECT_EQ(joined.delta().bias_jacobian, whole.delta().bias_jacobian);
  // Equal except for the rounding of the mean of two equal noises.
  EXPECT_LT((joined.covariance() - whole.covariance()).norm(), 1e-13 * whole.covariance().norm());
}

TEST(ImuPreintegration, JoinedIntervalsHaveTheNoiseOfBoth) {
  const auto samples = SinusoidalMotion(2.0).Samples(200.0, 1.0);
  const std::span<const ImuSample> all = samples;
  const auto preintegrate = [&](std::size_t begin, std::size_t count, double accelerometer) {
    return ImuPreintegration(all.subspan(begin, count), TestBias(),
                             {.noise = {.accelerometer = accelerometer}});
  };
  // A shaken first half and a calm second half: the variance is the sum of the white noise of
  // velocity.
  const ImuPreintegration shaken = preintegrate(0, 101, 0.05), calm = preintegrate(100, 101, 0.002);
  const auto velocity_variance = [](const ImuPreintegration& imu) {
    return imu.covariance().block<3, 3>(3, 3).trace();
  };
  const double sum = velocity_variance(shaken) + velocity_variance(calm);
  EXPECT_NEAR(velocity_variance(shaken.Joined(calm)) / sum, 1.0, 0.01) << "gyroscope apart";
}

TEST(ImuPreintegration, JoinsOnlyConsecutiveIntervals) {
  const auto samples = SinusoidalMotion().Samples(200.0, 0.5);
  const std::span<const ImuSample> all = samples;
  const ImuPreintegration first(all.first(41), ImuBias::Zero());
  EXPECT_THROW(first.Joined(ImuPreintegration(all.subspan(41), ImuBias::Zero())), InvalidArgument);
  EXPECT_THROW(first.Joined(ImuPreintegration(all.subspan(39), ImuBias::Zero())), InvalidArgument);
  EXPECT_THROW(first.Joined(first), InvalidArgument);
}

TEST(ImuPreintegration, CovarianceMatchesTenThousandNoisyRuns) {
  // The random walks are strong enough that every block of the 15 x 15 matrix is significant.
  const ImuPreintegrationOptions options{.noise = {.gyroscope = 2e-3,
                                                   .accelerometer = 2e-2,
                                                   .gyroscope_walk = 2e-3,
                                                   .accelerometer_walk = 3e-2}};
  constexpr double kHertz = 200.0;
  constexpr int kRuns = 10'000;
  const auto clean = SinusoidalMotion(2.0).Samples(kHertz, 0.5);
  const ImuPreintegration exact(clean, ImuBias::Zero(), options);
  const ImuDelta::Motion truth = exact.delta().At(ImuBias::Zero());

  std::mt19937 rng(5);
  std::normal_distribution<double> normal;
  const auto noise = [&](double sigma) {
    const double x = normal(rng), y = normal(rng), z = normal(rng);
    return Eigen::Vector3d(sigma * Eigen::Vector3d(x, y, z));
  };
  Matrix15 sampled = Matrix15::Zero();
  for (int run = 0; run < kRuns; ++run) {
    auto noisy = clean;
    ImuBias walk = ImuBias::Zero();
    for (ImuSample& sample : noisy) {
      sample.gyroscope += walk.head<3>() + noise(options.noise.gyroscope * std::sqrt(kHertz));
      sample.accelerometer +=
          walk.tail<3>() + noise(options.noise.accelerometer * std::sqrt(kHertz));
      walk.head<3>() += noise(options.noise.gyroscope_walk / std::sqrt(kHertz));
      walk.tail<3>() += noise(options.noise.accelerometer_walk / std::sqrt(kHertz));
    }
    const ImuPreintegration imu(noisy, ImuBias::Zero(), options);
    Eigen::Matrix<double, 15, 1> error;
    // Sign of the residual: true minus measured motion, end minus start of the bias.
    error << Difference(imu.delta().At(ImuBias::Zero()), truth), walk;
    sampled += error * error.transpose() / kRuns;
  }
  // Whitened by the prediction, the sampled covariance is the identity: its entries have a standard
  // error of 1.4 % (diagonal) and 1 %, and the discrete readings have 0.5 % less than the density.
  const Eigen::LLT<Matrix15> llt(exact.covariance());
  ASSERT_EQ(llt.info(), Eigen::Success);
  const Matrix15 half = llt.matrixL().solve(sampled);
  const Matrix15 whitened = llt.matrixL().solve(half.transpose());
  EXPECT_LT((whitened - Matrix15::Identity()).cwiseAbs().maxCoeff(), 0.07) << whitened;
  EXPECT_NEAR(whitened.trace() / 15.0, 1.0, 0.02);
}

TEST(ImuPreintegration, CovarianceIsThatOfTheStraightLineByHand) {
  // Without rotation: var theta = s_g^2 T, var v = s_a^2 T + q_a T^3 / 3, cov(v, p) = s_a^2 T^2 / 2
  // + q_a T^4 / 8, var p = s_a^2 T^3 / 3 + q_a T^5 / 20; cov(theta, b_g) = -q_g T^2 / 2.
  std::vector<ImuSample> samples;
  for (int i = 0; i <= 1000; ++i) samples.push_back({i * 1'000'000, {0, 0, 0}, {0, 0, 0}});
  const ImuNoise n{
      .gyroscope = 0.1, .accelerometer = 0.2, .gyroscope_walk = 0.3, .accelerometer_walk = 0.4};
  const Matrix15 P = ImuPreintegration(samples, ImuBias::Zero(), {.noise = n}).covariance();
  const double qg = 0.09, qa = 0.16;
  // The recursion is of second order in its step of 1e-3 s.
  EXPECT_NEAR(P(0, 0), 0.01 + qg / 3.0, 1e-6);
  EXPECT_NEAR(P(3, 3), 0.04 + qa / 3.0, 1e-6);
  EXPECT_NEAR(P(3, 6), 0.02 + qa / 8.0, 1e-6);
  EXPECT_NEAR(P(6, 6), 0.04 / 3.0 + qa / 20.0, 1e-6);
  EXPECT_NEAR(P(0, 9), -qg / 2.0, 1e-6);
  EXPECT_NEAR(P(3, 12), -qa / 2.0, 1e-6);
  EXPECT_NEAR(P(6, 12), -qa / 6.0, 1e-6);
  EXPECT_NEAR(P(9, 9), qg, 1e-12);
  EXPECT_NEAR(P(12, 12), qa, 1e-12);
}

TEST(ImuPreintegration, TwoReadingsGiveAProperCovariance) {
  const ImuPreintegration imu(SinusoidalMotion().Samples(200.0, 0.005), ImuBias::Zero());
  EXPECT_EQ(imu.samples().size(), 2u);
  EXPECT_EQ(Eigen::LLT<Matrix15>(imu.covariance()).info(), Eigen::Success);
  EXPECT_LT((imu.covariance() - imu.covariance().transpose()).norm(),
            1e-15 * imu.covariance().norm());
}

TEST(ImuPreintegration, ReadingsFarBeyondAnySensorHaveNoInformation) {
  std::vector<ImuSample> readings;
  for (int i = 0; i <= 20; ++i) readings.push_back({i * 5'000'000, {0, 0, 0}, {0, 0, 9.81}});
  EXPECT_TRUE(ImuPreintegration(readings, ImuBias::Zero()).HasInformation());
  readings[10].accelerometer.x() = 1e200;  // its square is not finite
  EXPECT_FALSE(ImuPreintegration(readings, ImuBias::Zero()).HasInformation());
}

TEST(ImuPreintegration, AllocatesOnceHoweverManySamples) {
  const auto samples = SinusoidalMotion().Samples(200.0, 5.0);
  const auto count = [&](std::size_t n) {
    const std::size_t before = allocations;
    const std::span<const ImuSample> all = samples;
    const ImuPreintegration imu(all.first(n), ImuBias::Zero());
    return allocations - before;
  };
  EXPECT_EQ(count(10), 1u);
  EXPECT_EQ(count(1000), 1u);
}

TEST(ImuPreintegration, RefusesBadArguments) {
  const auto good = SinusoidalMotion().Samples(200.0, 0.1);
  const auto with = [&](auto change) {
    auto samples = good;
    change(samples);
    return samples;
  };
  const ImuBias zero = ImuBias::Zero();
  EXPECT_THROW(ImuPreintegration(std::span(good).first(1), zero), InvalidArgument);
  EXPECT_THROW(ImuPreintegration(std::span(good).first(0), zero), InvalidArgument);
  EXPECT_THROW(ImuPreintegration(with([](auto& s) { s[3].gyroscope.x() = kNan; }), zero),
               InvalidArgument);
  EXPECT_THROW(ImuPreintegration(with([](auto& s) { s[3].accelerometer.z() = HUGE_VAL; }), zero),
               InvalidArgument);
  EXPECT_THROW(ImuPreintegration(with([](auto& s) { s[3].stamp = s[2].stamp; }), zero),
               InvalidArgument);
  EXPECT_THROW(ImuPreintegration(with([](auto& s) { std::swap(s[3], s[4]); }), zero),
               InvalidArgument);
  EXPECT_THROW(ImuPreintegration(good, ImuBias::Constant(kNan)), InvalidArgument);
  EXPECT_THROW(ImuPreintegration(good, zero, {.noise = {.gyroscope = 0.0}}), InvalidArgument);
  EXPECT_THROW(ImuPreintegration(good, zero, {.noise = {.accelerometer_walk = -1.0}}),
               InvalidArgument);
  EXPECT_THROW(ImuPreintegration(good, zero, {.max_gyroscope_change = kNan}), InvalidArgument);
}

}  // namespace
}  // namespace highwall::imu_preintegration_test
