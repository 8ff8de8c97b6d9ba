#include <cmath>
#include <memory>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include <highwall/core/error.h>
#include <highwall/core/manifolds.h>

#include "inertial/inertial_window.h"
#include "inertial_scene.h"

namespace highwall::inertial_window_test {
namespace {

using Matrix15 = Eigen::Matrix<double, 15, 15>;
using Vector15 = Eigen::Matrix<double, 15, 1>;
using Matrix18 = Eigen::Matrix<double, 18, 18>;
using testing::EstimateError;
using testing::InertialScene;
using testing::InertialSceneOptions;
using testing::Moved;
using testing::Start;
using testing::StartSigma;

InertialEstimate SomeEstimate() {
  const ImuState state = SinusoidalMotion(2.0).StateAt(0.0);
  return {.state = {Pose::FromTangent({1, 2, 3}, {0.3, -0.5, 0.9}) * state.T_WB, state.v_WB},
          .bias = (ImuBias() << 0.02, -0.03, 0.01, 0.1, -0.2, 0.15).finished()};
}

TEST(Propagate, CarriesTheCovarianceByTheJacobianOfThePrediction) {
  // The noise of the IMU itself is almost zero.
  const ImuPreintegrationOptions options{.noise = {.gyroscope = 1e-12,
                                                   .accelerometer = 1e-12,
                                                   .gyroscope_walk = 1e-12,
                                                   .accelerometer_walk = 1e-12}};
  InertialEstimate from = SomeEstimate();
  // The bias differs from the one of the integration.
  const ImuPreintegration imu(SinusoidalMotion(2.0).Samples(200.0, 0.3),
                              from.bias + ImuBias::Constant(0.003), options);
  std::mt19937 rng(1);
  std::normal_distribution<double> normal;
  Matrix15 A;
  for (int i = 0; i < 225; ++i) A.data()[i] = normal(rng);
  from.covariance = A * A.transpose();

  const InertialEstimate to = Propagate(from, imu, kGravity);
  EXPECT_EQ(to.stamp, imu.end());
  EXPECT_EQ(to.bias, from.bias);
  Matrix15 F;
  constexpr double kStep = 1e-5;
  for (int i = 0; i < 15; ++i) {
    const auto at = [&](double step) {
      const InertialEstimate end = Propagate(Moved(from, step * Vector15::Unit(i)), imu, kGravity);
      return Vector15(EstimateError(end.state, end.bias, to));
    };
    F.col(i) = (at(kStep) - at(-kStep)) / (2.0 * kStep);
  }
  // The correction for a bias 0.003 rad/s away is of first order: 1e-3 of its own Jacobian, 0.3.
  EXPECT_LT((to.covariance - F * from.covariance * F.transpose()).cwiseAbs().maxCoeff(),
            1e-3 * to.covariance.cwiseAbs().maxCoeff());
}

TEST(Propagate, CovarianceMatchesNoisyRuns) {
  // The random walks are strong, so that the blocks of the biases count.
  const ImuNoise noise{
      .gyroscope = 2e-3, .accelerometer = 2e-2, .gyroscope_walk = 5e-3, .accelerometer_walk = 5e-2};
  constexpr double kDuration = 0.4;
  constexpr int kRuns = 4000;
  InertialScene scene({.motion = 2.0, .noise = noise});
  InertialEstimate from{.state = scene.StateAt(0.0)};
  Vector15 sigma;
  sigma << Eigen::Vector3d::Constant(0.01), Eigen::Vector3d::Constant(0.005),
      Eigen::Vector3d::Constant(0.02), Eigen::Vector3d::Constant(0.002),
      Eigen::Vector3d::Constant(0.05);
  from.covariance = sigma.cwiseProduct(sigma).asDiagonal();
  Matrix15 sampled = Matrix15::Zero(), claimed = Matrix15::Zero();
  for (int run = 0; run < kRuns; ++run) {
    InertialScene one({.motion = 2.0, .noise = noise, .seed = static_cast<unsigned>(run + 1)});
    const auto readings = one.Readings(0.0, kDuration);
    Vector15 start;
    for (int i = 0; i < 5; ++i) start.segment<3>(3 * i) = one.Noise(sigma(3 * i));
    const InertialEstimate guess = Moved(from, start);
    const ImuPreintegration imu(readings, guess.bias, {.noise = noise});
    const InertialEstimate to = Propagate(guess, imu, kGravity);
    const Vector15 error = EstimateError(scene.StateAt(kDuration), one.bias(), to);
    sampled += error * error.transpose() / kRuns;
    claimed += to.covariance / kRuns;
  }
  // In units of the claimed deviations, an entry of a sampled covariance is accurate to sqrt(2 / N)
  // = 0.022.
  const Vector15 scale = claimed.diagonal().cwiseSqrt().cwiseInverse();
  const Matrix15 difference = scale.asDiagonal() * (sampled - claimed) * scale.asDiagonal();
  EXPECT_LT(difference.cwiseAbs().maxCoeff(), 0.1) << difference;
  const Matrix15 correlation = scale.asDiagonal() * claimed * scale.asDiagonal();
  EXPECT_GT((correlation - Matrix15::Identity()).cwiseAbs().maxCoeff(), 0.5) << "signs count";
}

TEST(CameraOf, MovesTheCovarianceToTheCamera) {
  std::mt19937 rng(2);
  std::normal_distribution<double> normal;
  Matrix15 A;
  for (int i = 0; i < 225; ++i) A.data()[i] = normal(rng);
  InertialEstimate body = SomeEstimate();
  body.covariance = A * A.transpose();
  const Pose T_BC = InertialScene::T_BC();
  const CameraPoseEstimate camera = CameraOf(body, T_BC);
  EXPECT_TRUE(camera.T_WC.Matrix().isApprox((body.state.T_WB * T_BC).Matrix(), 1e-14));
  Eigen::Matrix<double, 6, 6> J;
  constexpr double kStep = 1e-5;
  for (int i = 0; i < 6; ++i) {
    const auto at = [&](double step) {
      const Pose T = Moved(body, step * Vector15::Unit(i)).state.T_WB * T_BC;
      Eigen::Matrix<double, 6, 1> d;
      d << T.p(), so3::Log(camera.T_WC.q().conjugate() * T.q());
      return d;
    };
    J.col(i) = (at(kStep) - at(-kStep)) / (2.0 * kStep);
  }
  EXPECT_TRUE(
      camera.covariance.isApprox(J * body.covariance.topLeftCorner<6, 6>() * J.transpose(), 1e-8));
}

constexpr double kImageStep = 0.1;

struct Driven {
  std::unique_ptr<InertialWindow> window;
  ImuState truth;
  ImuBias bias;
};

// Runs a window with an image every kImageStep from 0.3 s on.
Driven Drive(const InertialSceneOptions& options, int images, const StartSigma& sigma,
             bool free_time_offset = true, int max_states = 5) {
  InertialScene scene(options);
  ImuBuffer buffer;
  for (const ImuSample& reading : scene.Readings(0.0, 0.3)) buffer.Add(reading);
  const InertialPrior prior = Start(scene, 0.3, options.time_offset, sigma);
  Driven driven;
  driven.window = std::make_unique<InertialWindow>(
      *InertialWindow::Make(scene.calibration(), SlidingWindowOptions{.max_states = max_states},
                            prior, free_time_offset));
  InertialWindow& window = *driven.window;
  double read = 0.3;
  for (int k = 1; k <= images; ++k) {
    const double t = 0.3 + kImageStep * k;
    driven.bias = scene.bias();
    for (const ImuSample& reading : scene.Readings(read + 0.005, t + 0.05)) buffer.Add(reading);
    read = t + 0.05;
    const Stamp to = FromSeconds(t + window.time_offset());
    const auto interval = buffer.Between(window.newest().stamp, to);
    EXPECT_TRUE(interval);
    const ImuPreintegration imu(interval->samples, window.newest().bias,
                                {.noise = scene.calibration().noise});
    const VisualPose visual = scene.See(t);
    // The rate is the true one: the mean reading is the subject of RateAt().
    const Eigen::Vector3d omega_B = SinusoidalMotion(options.motion).SampleAt(to).gyroscope;
    EXPECT_TRUE(window.Add({.imu = &imu, .visual = &visual, .omega_B = omega_B}));
    EXPECT_EQ(window.newest().stamp, to);
  }
  driven.truth = scene.StateAt(ToSeconds(window.newest().stamp));
  driven.bias = scene.bias();
  return driven;
}

TEST(InertialWindow, TracksTheTruthFromGoodImages) {
  const InertialSceneOptions scene{.noise = {.gyroscope = 2e-5,
                                             .accelerometer = 1.5e-4,
                                             .gyroscope_walk = 2e-6,
                                             .accelerometer_walk = 1e-4},
                                   .bias = (ImuBias() << 0.01, 0, -0.01, 0.1, -0.1, 0).finished(),
                                   .position_sigma = 1e-4,
                                   .rotation_sigma = 1e-4};
  const Driven driven = Drive(scene, 40, {}, true, 10);
  const Vector15 error = EstimateError(driven.truth, driven.bias, driven.window->newest());
  // The bounds are the images' own noise, and its effect over the second of the window.
  EXPECT_LT(error.head<3>().norm(), 3e-4);       // [m]
  EXPECT_LT(error.segment<3>(3).norm(), 3e-4);   // [rad]
  EXPECT_LT(error.segment<3>(6).norm(), 2e-3);   // [m/s]
  EXPECT_LT(error.segment<3>(9).norm(), 5e-4);   // [rad/s]
  EXPECT_LT(error.segment<3>(12).norm(), 0.01);  // [m/s^2]
  EXPECT_NEAR(driven.window->time_offset(), 0.0, 1e-4);
  EXPECT_LT(testing::AngleBetween(driven.window->gravity_W().vector(), kGravity), 1e-3);
}

TEST(InertialWindow, IsConsistentOverFiftySeeds) {
  // NEES of all 15, of velocity and of the biases, after marginalization: means over N runs of
  // chi-squared, n +- sqrt(2 n / N).
  constexpr int kRuns = 50;
  double all = 0.0, velocity = 0.0, biases = 0.0, offset = 0.0;
  for (unsigned seed = 1; seed <= kRuns; ++seed) {
    const InertialSceneOptions scene{.time_offset = 0.005, .seed = seed};
    const Driven driven = Drive(scene, 12, {});
    const InertialEstimate& estimate = driven.window->newest();
    const Vector15 error = EstimateError(driven.truth, driven.bias, estimate);
    const Matrix15& P = estimate.covariance;
    all += error.dot(P.ldlt().solve(error));
    velocity += error.segment<3>(6).dot(P.block<3, 3>(6, 6).ldlt().solve(error.segment<3>(6)));
    biases += error.tail<6>().dot(P.block<6, 6>(9, 9).ldlt().solve(error.tail<6>()));
    const double d = driven.window->time_offset() - 0.005;
    offset += d * d / std::pow(driven.window->Prior().time_offset_sigma(), 2);
  }
  const auto bound = [&](double n) { return 4.0 * std::sqrt(2.0 * n / kRuns); };
  RecordProperty("nees", std::to_string(all / kRuns));
  EXPECT_NEAR(all / kRuns, 15.0, bound(15.0));
  EXPECT_NEAR(velocity / kRuns, 3.0, bound(3.0));
  EXPECT_NEAR(biases / kRuns, 6.0, bound(6.0));
  EXPECT_NEAR(offset / kRuns, 1.0, bound(1.0));
}

// Returns the error of T_BC, in the tangent of its covariance.
Eigen::Matrix<double, 6, 1> ExtrinsicsError(const Pose& T_BC) {
  const Pose truth = InertialScene::T_BC();
  Eigen::Matrix<double, 6, 1> error;
  error << truth.p() - T_BC.p(), so3::Log(T_BC.q().conjugate() * truth.q());
  return error;
}

TEST(InertialWindow, ExtrinsicsAreConsistentOverFiftySeeds) {
  // Means over N runs of chi-squared, n +- sqrt(2 n / N): of all 21, of T_BC, of the camera.
  constexpr int kRuns = 50;
  double body = 0.0, extrinsics = 0.0, known = 0.0;
  for (unsigned seed = 1; seed <= kRuns; ++seed) {
    const Driven driven = Drive({.seed = seed}, 30, {.T_BC = 0.01});
    const InertialPrior prior = driven.window->Prior();
    const Vector15 error = EstimateError(driven.truth, driven.bias, prior.estimate);
    body += error.dot(prior.estimate.covariance.ldlt().solve(error));
    const Eigen::Matrix<double, 6, 6> P = prior.calibration_covariance.bottomRightCorner<6, 6>();
    const Eigen::Matrix<double, 6, 1> of_T_BC = ExtrinsicsError(*prior.T_BC);
    extrinsics += of_T_BC.dot(P.ldlt().solve(of_T_BC));
    known += P.diagonal().cwiseSqrt().maxCoeff() / kRuns;
  }
  const auto bound = [&](double n) { return 4.0 * std::sqrt(2.0 * n / kRuns); };
  EXPECT_NEAR(body / kRuns, 15.0, bound(15.0));
  EXPECT_NEAR(extrinsics / kRuns, 6.0, bound(6.0));
  EXPECT_LT(known, 0.005) << "half of the prior";
}

TEST(PredictCamera, CountsTheUncertaintyOfTheExtrinsicsOnce) {
  std::mt19937 rng(4);
  std::normal_distribution<double> normal;
  Eigen::Matrix<double, 24, 24> A;
  for (int i = 0; i < 24 * 24; ++i) A.data()[i] = normal(rng);
  InertialPrior from;
  from.estimate = SomeEstimate();
  from.gravity_W = UnitDirection(kGravity);
  from.T_BC = InertialScene::T_BC();
  from.SetJoint(A * A.transpose());
  const ImuPreintegration imu(SinusoidalMotion(2.0).Samples(200.0, 0.3), from.estimate.bias,
                              {.noise = {.gyroscope = 1e-12,
                                         .accelerometer = 1e-12,
                                         .gyroscope_walk = 1e-12,
                                         .accelerometer_walk = 1e-12}});
  const CameraPoseEstimate camera = PredictCamera(from, *from.T_BC, imu);
  Eigen::Matrix<double, 6, 24> J = Eigen::Matrix<double, 6, 24>::Zero();
  constexpr double kStep = 1e-5;
  for (int i = 0; i < 24; ++i) {
    if (i >= 15 && i < 18) continue;  // gravity and t_d are assumed known
    const auto at = [&](double step) {
      InertialPrior moved = from;
      if (i < 15) {
        moved.estimate = Moved(from.estimate, step * Vector15::Unit(i));
      } else {
        moved.T_BC = from.T_BC->Plus(step * Eigen::Matrix<double, 6, 1>::Unit(i - 18));
      }
      const Pose T = PredictCamera(moved, *moved.T_BC, imu).T_WC;
      Eigen::Matrix<double, 6, 1> d;
      d << T.p(), so3::Log(camera.T_WC.q().conjugate() * T.q());
      return d;
    };
    J.col(i) = (at(kStep) - at(-kStep)) / (2.0 * kStep);
  }
  // As for the covariance of the body, the bias enters to first order.
  EXPECT_TRUE(camera.covariance.isApprox(J * from.Joint() * J.transpose(), 1e-6));
}

TEST(CameraMotion, IsTheDerivativeOfItsPose) {
  const SinusoidalMotion motion;
  const Pose T_BC = InertialScene::T_BC();
  constexpr double kTime = 0.7, h = 1e-4;  // [s]
  const auto T_WC = [&](double t) { return motion.StateAt(t).T_WB * T_BC; };
  const Twist truth = Twist::Between(T_WC(kTime - h).Inverse() * T_WC(kTime + h), 2.0 * h);
  const Twist found =
      CameraMotion(motion.StateAt(kTime), motion.SampleAt(FromSeconds(kTime)).gyroscope, T_BC);
  // The difference is off by the third derivative times h^2 / 6.
  EXPECT_LT((found.v - truth.v).norm(), 1e-6);
  EXPECT_LT((found.omega - truth.omega).norm(), 1e-6);
  EXPECT_GT(truth.v.norm(), 0.1);
  EXPECT_GT(truth.omega.norm(), 0.1);
}

TEST(CameraMotion, FollowsFromTwoPlacesAndTheReadingsBetweenThem) {
  const SinusoidalMotion motion(2.0);
  const Pose T_BC = InertialScene::T_BC();
  const ImuBias bias = SomeEstimate().bias;
  const std::vector<ImuSample> samples = WithBias(motion.Samples(1000.0, 0.3), bias);
  // Another bias than that of the integration, which is corrected to first order.
  const ImuPreintegration imu(samples, bias + ImuBias::Constant(0.001), {});
  const ImuState begin = motion.StateAt(ToSeconds(imu.start()));
  const Eigen::Vector3d end = motion.StateAt(ToSeconds(imu.end())).T_WB.p();
  const Twist truth = CameraMotion(begin, samples.front().gyroscope - bias.head<3>(), T_BC);
  const Twist found = CameraMotionBefore(imu, bias, kGravity, begin.T_WB, end, T_BC);
  // [m/s] the error of the integration over steps of a millisecond, divided by 0.3 s.
  EXPECT_LT((found.v - truth.v).norm(), 1e-4);
  EXPECT_LT((found.omega - truth.omega).norm(), 1e-12);
  EXPECT_GT(truth.v.norm(), 0.1);
}

TEST(InertialWindow, WithoutImagesTheCovarianceGrows) {
  InertialScene scene;
  const auto readings = scene.Readings(0.0, 1.0);
  InertialWindow window =
      *InertialWindow::Make(scene.calibration(), {}, Start(scene, 0.0, 0.0, {.t_d = 1e-9}), true);
  double previous = 0.0;
  for (int k = 0; k < 8; ++k) {
    const std::size_t begin = static_cast<std::size_t>(20 * k);
    auto part = std::vector<ImuSample>(readings.begin() + static_cast<std::ptrdiff_t>(begin),
                                       readings.begin() + static_cast<std::ptrdiff_t>(begin) + 21);
    // The window begins at the instant given by its offset, up to a nanosecond or two.
    part.front().stamp = window.newest().stamp;
    const ImuPreintegration imu(part, window.newest().bias);
    ASSERT_TRUE(window.Add({.imu = &imu}));
    const double sigma = window.newest().covariance.topLeftCorner<3, 3>().trace();
    EXPECT_GT(sigma, previous) << k;
    previous = sigma;
  }
}

TEST(InertialWindow, AStationaryBodyHasNoVelocity) {
  InertialScene scene({.motion = 0.0});
  const auto readings = scene.Readings(0.0, 0.1);
  for (const bool stationary : {false, true}) {
    InertialPrior prior = Start(scene, 0.0, 0.0, {});
    prior.estimate.stamp = 0;
    prior.estimate.state.v_WB = Eigen::Vector3d(0.02, -0.02, 0.02);
    InertialWindow window = *InertialWindow::Make(scene.calibration(), {}, prior, false);
    const ImuPreintegration imu(readings, prior.estimate.bias);
    ASSERT_TRUE(window.Add({.imu = &imu, .stationary = stationary}));
    EXPECT_EQ(window.newest().state.v_WB.norm() < 0.01, stationary);
  }
}

// At rest and level, the uncertainty of an accelerometer bias is that of gravity: sigma_b / g along
// that axis, reduced by the prior's tenth of a radian; across it rest constrains gravity to 0.02.
TEST(InertialWindow, SigmaOfGravityIsThatOfItsLessCertainAxis) {
  std::vector<ImuSample> readings;
  for (int i = 0; i <= 20; ++i) readings.push_back({i * 5'000'000, {0, 0, 0}, -kGravity});
  for (const int uncertain : {12, 13}) {  // x and y of b_a
    InertialPrior prior;
    Vector15 sigma = Vector15::Constant(1e-3);
    sigma(uncertain) = 2.0;
    prior.estimate.covariance = sigma.cwiseProduct(sigma).asDiagonal();
    prior.gravity_W = UnitDirection(kGravity);
    prior.calibration_covariance = Eigen::Vector3d(0.01, 0.01, 0.01).asDiagonal();
    InertialWindow window = *InertialWindow::Make(ImuCalibration(), {}, prior, false);
    const ImuPreintegration imu(readings, ImuBias::Zero());
    ASSERT_TRUE(window.Add({.imu = &imu, .stationary = true}));
    // The value is 1 / sqrt(1 / 0.1^2 + (g / 2)^2), plus a little for the other unknowns.
    EXPECT_NEAR(window.Prior().gravity_sigma(), 0.09, 0.005) << uncertain;
  }
}

TEST(InertialWindow, APriorThatIsNoGaussianMakesNoWindow) {
  InertialScene scene;
  const auto make = [&](const InertialPrior& prior) {
    return InertialWindow::Make(scene.calibration(), {}, prior, true).has_value();
  };
  const InertialPrior good = Start(scene, 0.0, 0.0, {.t_d = 1e-9});
  EXPECT_TRUE(make(good));
  InertialPrior bad = good;
  bad.estimate.covariance(3, 3) = -1.0;
  EXPECT_FALSE(make(bad));
  bad = good;
  bad.estimate.state.v_WB.x() = NAN;
  EXPECT_FALSE(make(bad));
  EXPECT_THROW(InertialWindow::Make(scene.calibration(), {.max_states = 0}, good, true),
               InvalidArgument);
}

// A window that starts from the prior of another one has the same information, couplings included.
TEST(InertialWindow, ContinuesFromThePriorOfAnotherWindow) {
  for (const bool free_time_offset : {true, false}) {
    const Driven driven = Drive({.time_offset = 0.0}, 8, {.t_d = 1e-9}, free_time_offset);
    const InertialPrior prior = driven.window->Prior();
    const Matrix18 joint = prior.Joint();
    ASSERT_GT(prior.coupling.cwiseAbs().maxCoeff(), 0.0);
    const InertialWindow next =
        *InertialWindow::Make(InertialScene().calibration(), {}, prior, free_time_offset);
    EXPECT_TRUE(
        next.newest().state.T_WB.Matrix().isApprox(prior.estimate.state.T_WB.Matrix(), 1e-12));
    const int known = free_time_offset ? 18 : 17;
    const Eigen::VectorXd scale = joint.diagonal().head(known).cwiseSqrt().cwiseInverse();
    const Eigen::MatrixXd difference = scale.asDiagonal() *
                                       (next.Prior().Joint() - joint).topLeftCorner(known, known) *
                                       scale.asDiagonal();
    // The tolerance is the rounding of an inverse whose correlations leave a condition of some 1e6.
    EXPECT_LT(difference.cwiseAbs().maxCoeff(), 1e-6) << free_time_offset;
  }
}

// Gravity and the accelerometer's bias are each uncertain, but their combination is known.
TEST(InertialWindow, JointCovarianceOfGravityAndBiasPredictsTheMotion) {
  std::vector<ImuSample> readings;
  for (int i = 0; i <= 20; ++i) readings.push_back({i * 5'000'000, {0, 0, 0}, -kGravity});
  const ImuPreintegration imu(readings, ImuBias::Zero());
  for (const bool coupled : {false, true}) {
    Matrix18 joint = 1e-10 * Matrix18::Identity();
    // The tilt is about y or x by sigma; the bias along x or y is indistinguishable from it at
    // rest.
    constexpr double kTilt = 0.01;  // [rad]
    const Eigen::Matrix<double, 3, 2> basis =
        UnitDirectionManifold::Basis(UnitDirection(kGravity).data());
    const Eigen::Matrix<double, 3, 2> bias = 9.81 * basis;
    const Eigen::Matrix2d tilt = kTilt * kTilt * Eigen::Matrix2d::Identity();
    joint.block<2, 2>(15, 15) += tilt;
    joint.block<3, 3>(12, 12) += bias * tilt * bias.transpose();
    // With R = I, a constant specific force b + (a - g) makes the bias follow g.
    if (coupled) {
      joint.block<3, 2>(12, 15) = bias * tilt;
      joint.block<2, 3>(15, 12) = joint.block<3, 2>(12, 15).transpose();
    }
    InertialPrior prior;
    prior.gravity_W = UnitDirection(kGravity);
    prior.SetJoint(joint);
    InertialWindow window = *InertialWindow::Make(ImuCalibration(), {}, prior, false);
    ASSERT_TRUE(window.Add({.imu = &imu}));
    const double velocity = std::sqrt(window.newest().covariance(6, 6));
    // Two contributions of 0.1 s at 9.81 m/s^2 times a hundredth; the rest is the noise of the
    // readings.
    if (coupled) {
      EXPECT_LT(velocity, 2e-3);
    } else {
      EXPECT_NEAR(velocity, 0.1 * 9.81 * kTilt * std::sqrt(2.0), 1e-3);
    }
  }
}

TEST(InertialPrior, TurnsWithItsWorld) {
  std::mt19937 rng(3);
  std::normal_distribution<double> normal;
  Matrix18 A;
  for (int i = 0; i < 18 * 18; ++i) A.data()[i] = normal(rng);
  InertialPrior prior;
  prior.estimate = SomeEstimate();
  prior.gravity_W = UnitDirection(Eigen::Vector3d(0.2, -0.1, -1.0));
  prior.SetJoint(A * A.transpose());
  const Eigen::Quaterniond q = so3::Exp(Eigen::Vector3d(0.3, -0.2, 0.5));
  const InertialPrior turned = prior.Turned(q);
  EXPECT_TRUE(turned.estimate.state.v_WB.isApprox(q * prior.estimate.state.v_WB, 1e-14));
  EXPECT_TRUE(turned.gravity_W.vector().isApprox(q * prior.gravity_W.vector(), 1e-14));
  EXPECT_EQ(turned.time_offset, prior.time_offset);
  // [p theta v b_g b_a g t_d]: gravity's direction is expressed in space, independent of the basis
  // of its tangent. Quantities in the body's axes, rotations and biases, do not rotate with the
  // world.
  using Matrix19 = Eigen::Matrix<double, 19, 19>;
  const auto spatial = [](const InertialPrior& p) {
    Eigen::Matrix<double, 19, 18> J = Eigen::Matrix<double, 19, 18>::Zero();
    J.topLeftCorner<15, 15>().setIdentity();
    J.block<3, 2>(15, 15) = UnitDirectionManifold::Basis(p.gravity_W.data());
    J(18, 17) = 1.0;
    return Matrix19(J * p.Joint() * J.transpose());
  };
  Matrix19 R = Matrix19::Identity();
  for (const int turning : {0, 6, 15}) {
    R.block<3, 3>(turning, turning) = q.toRotationMatrix();
  }
  EXPECT_TRUE(spatial(turned).isApprox(R * spatial(prior) * R.transpose(), 1e-12));
}

TEST(Propagate, ALesserWeightIsALargerNoise) {
  InertialScene scene;
  const ImuPreintegration imu(scene.Readings(0.0, 0.1), ImuBias::Zero());
  InertialEstimate from = SomeEstimate();
  from.covariance.setZero();
  const Matrix15 one = Propagate(from, imu, kGravity).covariance;
  EXPECT_TRUE(Propagate(from, imu, kGravity, 0.25).covariance.isApprox(4.0 * one, 1e-12));
}

TEST(InertialWindow, AnOffsetThatIsNotFreeStaysAsItWas) {
  const Driven driven = Drive({.time_offset = 0.0}, 5, {.t_d = 1e-9}, false);
  EXPECT_NEAR(driven.window->time_offset(), 0.0, 1e-8);
  EXPECT_EQ(driven.window->Prior().time_offset_sigma(), 0.0);
}

}  // namespace
}  // namespace highwall::inertial_window_test
