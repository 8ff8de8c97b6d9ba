#include "inertial/visual_inertial_window.h"

#include <cmath>
#include <optional>
#include <random>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <highwall/core/error.h>
#include <highwall/core/so3.h>
#include <highwall/frontend/map/seen_landmarks.h>

#include "inertial_scene.h"
#include "mapped_place.h"

namespace highwall::visual_inertial_window_test {
namespace {

using Matrix15 = Eigen::Matrix<double, 15, 15>;
using Vector15 = Eigen::Matrix<double, 15, 1>;
using testing::EstimateError;
using testing::InertialScene;
using testing::InertialSceneOptions;
using testing::kImageStep;
using testing::kStart;
using testing::MappedPlace;
using testing::Start;
using testing::StartSigma;

// A window that receives an image every kImageStep. doubt: stated standard deviation of the start
// pose, [m] and tenths of a radian.
class Drive {
 public:
  Drive(const InertialSceneOptions& scene, const InertialOptions& options,
        const StartSigma& sigma = {}, double noise = 1.0, double doubt = 0.0,
        const MapDrift& drift = {})
      : place_(scene, noise), motion_(scene.motion) {
    InertialScene& truth = place_.scene();
    for (const ImuSample& reading : truth.Readings(0.0, kStart)) buffer_.Add(reading);
    InertialPrior prior = Start(truth, kStart, scene.time_offset, sigma);
    if (doubt > 0.0) {
      const Eigen::Vector3d position = Eigen::Vector3d::Constant(doubt * doubt);
      prior.estimate.covariance.diagonal().head<6>() << position, 0.01 * position;
    }
    window_.emplace(
        *VisualInertialWindow::Make(truth.calibration(), place_.model(), options, prior, drift));
  }

  // map_drifts [m/s]: along x. blind: images show nothing.
  void Go(int images, double map_drifts = 0.0, bool blind = false) {
    for (int k = 0; k < images; ++k) {
      const double t = kStart + kImageStep * ++image_;
      InertialScene& truth = place_.scene();
      for (const ImuSample& reading : truth.Readings(read_ + 0.005, t + 0.05)) buffer_.Add(reading);
      read_ = t + 0.05;
      const Stamp to = FromSeconds(t + window_->time_offset());
      const auto interval = buffer_.Between(window_->newest().stamp, to);
      ASSERT_TRUE(interval);
      const ImuPreintegration imu(interval->samples, window_->newest().bias,
                                  {.noise = truth.calibration().noise});
      const Pose drift(Eigen::Quaterniond::Identity(), {map_drifts * kImageStep, 0, 0});
      place_.MoveMap(drift);
      T_MW_ = drift * T_MW_;
      const SeenLandmarks seen = place_.See(t);
      // The rate is the true one: the mean reading is the subject of RateAt().
      const Eigen::Vector3d omega_B = motion_.SampleAt(to).gyroscope;
      ASSERT_TRUE(window_->Add({.imu = &imu,
                                .seen = blind ? nullptr : &seen,
                                .time_offset = ToSeconds(to) - t,
                                .omega_B = omega_B}));
      EXPECT_EQ(window_->newest().stamp, to);
    }
  }

  // Adds one image with a stop already requested; returns whether it was added.
  bool GoWithStop() {
    const double t = kStart + kImageStep * ++image_;
    for (const ImuSample& reading : place_.scene().Readings(read_ + 0.005, t + 0.05)) {
      buffer_.Add(reading);
    }
    read_ = t + 0.05;
    const auto interval = buffer_.Between(window_->newest().stamp, FromSeconds(t));
    const ImuPreintegration imu(interval->samples, window_->newest().bias);
    const SeenLandmarks seen = place_.See(t);
    std::stop_source stop;
    stop.request_stop();
    return window_->Add({.imu = &imu, .seen = &seen}, stop.get_token());
  }

  // Returns the error in the world of the map.
  Vector15 Error() {
    ImuState truth = place_.scene().StateAt(ToSeconds(window_->newest().stamp));
    truth.T_WB = T_MW_ * truth.T_WB;
    return EstimateError(truth, place_.scene().bias(), window_->newest());
  }
  const VisualInertialWindow& window() const { return *window_; }

 private:
  MappedPlace place_;
  SinusoidalMotion motion_;
  ImuBuffer buffer_;
  std::optional<VisualInertialWindow> window_;
  Pose T_MW_;  // of the true world in that of the map
  int image_ = 0;
  double read_ = kStart;
};

// Returns options with few landmarks, so that a test of many runs is short.
InertialOptions FewLandmarks() {
  InertialOptions options;
  options.tight.max_points = 40;
  options.tight.max_lines = 10;
  options.visual_noise.scale = 1.0;  // errors are independent here
  return options;
}

TEST(VisualInertialWindow, TracksTheTruthFromGoodImages) {
  const InertialSceneOptions scene{.noise = {.gyroscope = 2e-5,
                                             .accelerometer = 1.5e-4,
                                             .gyroscope_walk = 2e-6,
                                             .accelerometer_walk = 1e-4},
                                   .bias = (ImuBias() << 0.01, 0, -0.01, 0.1, -0.1, 0).finished()};
  Drive drive(scene, FewLandmarks(), {}, 0.0);
  drive.Go(35);
  const Vector15 error = drive.Error();
  // These are the remaining errors of the start; images are without noise, but weighted as if
  // noisy.
  EXPECT_LT(error.head<3>().norm(), 1e-3);               // [m]
  EXPECT_LT(error.segment<3>(3).norm(), 5e-4);           // [rad], of 1.7e-3
  EXPECT_LT(error.segment<3>(6).norm(), 4e-3);           // [m/s], of 0.035
  EXPECT_LT(error.segment<3>(9).norm(), 5e-4);           // [rad/s], of 1.7e-3
  EXPECT_LT(error.segment<3>(12).norm(), 0.02);          // [m/s^2], of 0.035
  EXPECT_NEAR(drive.window().time_offset(), 0.0, 5e-4);  // [s], of 2e-3
  EXPECT_LT(testing::AngleBetween(drive.window().gravity_W().vector(), kGravity), 2e-3);
}

TEST(VisualInertialWindow, PointsAloneAndLinesAloneFindTheTimeOffset) {
  for (const auto& [points, lines] : {std::pair(40, 0), std::pair(0, 40)}) {
    InertialOptions options = FewLandmarks();
    options.tight.max_points = points;
    options.tight.max_lines = lines;
    Drive drive({.time_offset = 0.008}, options, {.t_d = 5e-3});
    drive.Go(30);
    const double sigma = drive.window().Prior().time_offset_sigma();
    EXPECT_LT(sigma, 7e-4) << points << " points";  // of 5 ms
    EXPECT_NEAR(drive.window().time_offset(), 0.008, 3.0 * sigma) << points << " points";
  }
}

TEST(VisualInertialWindow, AnOffsetThatIsNotFreeStaysAsItWas) {
  InertialOptions options = FewLandmarks();
  options.estimate_time_offset = false;
  Drive drive({.time_offset = 0.008}, options, {.t_d = 1e-3});
  const double before = drive.window().time_offset();
  drive.Go(8);
  EXPECT_EQ(drive.window().time_offset(), before);
}

TEST(VisualInertialWindow, MotionIsConsistentOverThirtySeeds) {
  // NEES of velocity, of the biases and of t_d, after marginalization: means over N runs of
  // chi-squared, n +- sqrt(2 n / N). The pose is excluded: the keyframes' observations of a
  // landmark are the same each time it begins, so that the map's own error averages out less than
  // stated.
  constexpr int kRuns = 30;
  double pose = 0.0, velocity = 0.0, biases = 0.0, offset = 0.0;
  for (unsigned seed = 1; seed <= kRuns; ++seed) {
    InertialOptions options = FewLandmarks();
    options.window_states = 4;
    Drive drive({.time_offset = 0.005, .seed = seed}, options);
    drive.Go(25);
    const Vector15 error = drive.Error();
    const Matrix15& P = drive.window().newest().covariance;
    pose += error.head<6>().dot(P.topLeftCorner<6, 6>().ldlt().solve(error.head<6>()));
    velocity += error.segment<3>(6).dot(P.block<3, 3>(6, 6).ldlt().solve(error.segment<3>(6)));
    biases += error.tail<6>().dot(P.block<6, 6>(9, 9).ldlt().solve(error.tail<6>()));
    const double d = drive.window().time_offset() - 0.005;
    offset += d * d / std::pow(drive.window().Prior().time_offset_sigma(), 2);
  }
  const auto bound = [&](double n) { return 4.0 * std::sqrt(2.0 * n / kRuns); };
  RecordProperty("velocity", std::to_string(velocity / kRuns));
  EXPECT_NEAR(velocity / kRuns, 3.0, bound(3.0));
  EXPECT_NEAR(biases / kRuns, 6.0, bound(6.0));
  EXPECT_NEAR(offset / kRuns, 1.0, bound(1.0));
  EXPECT_GT(offset / kRuns, 0.3);
  EXPECT_GT(pose / kRuns, 6.0 - bound(6.0));
  EXPECT_LT(pose / kRuns, 4.0 * 6.0);  // two standard deviations instead of one
}

TEST(VisualInertialWindow, KeepsTheInformationOfMarginalizedStates) {
  // Nothing changes gravity: it is known better with each state.
  InertialOptions options = FewLandmarks();
  options.window_states = 4;
  Drive drive({}, options);
  double before = drive.window().Prior().gravity_sigma();
  for (int k = 0; k < 30; ++k) {
    drive.Go(1);
    const double after = drive.window().Prior().gravity_sigma();
    EXPECT_LT(after, 1.01 * before) << "image " << k;  // relinearized each time
    before = after;
  }
  EXPECT_LT(before, 0.75 * 2e-3);  // [rad] that of the start
}

// Returns the information [1/m^2, 1/rad^2] on the four motions that only the start constrains: all
// of V moved along an axis, or rotated about gravity.
Eigen::Vector4d GaugeInformation(const VisualInertialWindow& window) {
  const Eigen::MatrixXd& all = window.covariance_V();  // [pose, velocity, bias ... T_VW]
  std::vector<Eigen::Index> rows;
  for (Eigen::Index k = 0; k < 9; ++k) rows.push_back(k);
  for (Eigen::Index k = all.rows() - 6; k < all.rows(); ++k) rows.push_back(k);
  const Eigen::MatrixXd P = all(rows, rows);  // 6 + 3 + 6
  const auto& [T_VB, T_VW, v_V, bias] = window.newest_V();
  const Eigen::Vector3d up = T_VW.q() * window.gravity_W().vector();
  Eigen::Matrix<double, 15, 4> D = Eigen::Matrix<double, 15, 4>::Zero();
  D.topLeftCorner<3, 3>().setIdentity();
  D.block<3, 3>(9, 0).setIdentity();
  D.col(3) << up.cross(T_VB.p()), T_VB.q().conjugate() * up, up.cross(v_V), up.cross(T_VW.p()),
      T_VW.q().conjugate() * up;
  const Eigen::MatrixXd information = P.inverse();
  return (D.transpose() * information * D).diagonal();
}

TEST(VisualInertialWindow, PositionAndYawGainNoInformation) {
  // The position of V is hardly known at the start: the images' information on the map, a million
  // times as much, must not leak into it.
  InertialOptions options = FewLandmarks();
  options.window_states = 4;
  options.visual_noise.position = 1.0;
  options.visual_noise.rotation = 0.1;
  Drive drive({}, options, {}, 1.0, 1.0);
  const Eigen::Vector4d before = GaugeInformation(drive.window());
  EXPECT_NEAR(before[0], 2.0, 1e-3);  // 1 m of the body and 1 m of the map
  for (int k = 0; k < 8; ++k) {
    drive.Go(5);
    const Eigen::Vector4d after = GaugeInformation(drive.window());
    // Yaw gains 4 % of the information of a standard deviation of a degree by relinearization.
    for (int i = 0; i < 4; ++i) EXPECT_LT(after[i], 1.1 * before[i]) << 5 * k << " axis " << i;
  }
}

TEST(VisualInertialWindow, FollowsAMapThatDriftsAlong) {
  InertialOptions options = FewLandmarks();
  options.window_states = 4;
  Drive drive({}, options, {}, 0.0, 0.0,
              {.position = 5e-3});  // image noise alone would move 40 points by as much
  drive.Go(35, 5e-3);               // the map shifts by 12 mm, consistently in all keyframes
  const Vector15 error = drive.Error();
  // No landmark began before the window, 0.27 s ago, when the map was 1.3 mm away.
  EXPECT_LT(error.head<3>().norm(), 2.5e-3);    // [m]
  EXPECT_LT(error.segment<3>(6).norm(), 0.01);  // [m/s] twice that speed
}

// With image noise the error of the newest position matches its covariance, and its mean lag behind
// the map is no larger than above.
TEST(VisualInertialWindow, NoiseOfImagesDoesNotHoldItBackFromAMapThatDriftsOverTwentySeeds) {
  constexpr int kRuns = 20;
  Eigen::Vector3d behind = Eigen::Vector3d::Zero();
  double position = 0.0, variance = 0.0;
  for (unsigned seed = 1; seed <= kRuns; ++seed) {
    InertialOptions options = FewLandmarks();
    options.window_states = 4;
    Drive drive({.seed = seed}, options, {}, 1.0, 0.0, {.position = 5e-3});
    drive.Go(35, 5e-3);
    const Eigen::Vector3d error = drive.Error().head<3>();
    const Eigen::Matrix3d P = drive.window().newest().covariance.topLeftCorner<3, 3>();
    behind += error / kRuns;
    position += error.dot(P.ldlt().solve(error)) / kRuns;
    variance += P.trace() / kRuns;
  }
  RecordProperty("behind_mm", std::to_string(1e3 * behind.norm()));
  RecordProperty("sigma_mm", std::to_string(1e3 * std::sqrt(variance)));
  RecordProperty("position", std::to_string(position));
  EXPECT_LT(behind.norm(), 1.3e-3 + 4.0 * std::sqrt(variance / kRuns));  // [m]
  EXPECT_NEAR(position, 3.0, 4.0 * std::sqrt(2.0 * 3.0 / kRuns));        // chi-squared of three
}

// A start that is known to 0.5 m and 0.05 rad leaves the pose to the image.
TEST(VisualInertialWindow, LandmarksWhoseErrorsAreNotIndependentCountForLess) {
  InertialOptions options = FewLandmarks();
  options.visual_noise.position = 1e-5;
  options.visual_noise.rotation = 1e-6;
  const auto variance = [&](double scale) {
    options.visual_noise.scale = scale;
    Drive drive({}, options, {}, 1.0, 0.5);
    drive.Go(1);
    return drive.window().newest().covariance.diagonal().head<6>().eval();
  };
  const Eigen::Array<double, 6, 1> ratio = variance(9.0).array() / variance(1.0).array();
  // The ratio is below nine: at any scale the landmarks' positions in the map, from a few views
  // each, contribute the same uncertainty.
  EXPECT_GT(ratio.minCoeff(), 1.8) << ratio.transpose();
  EXPECT_LT(ratio.maxCoeff(), 9.0) << ratio.transpose();
}

TEST(VisualInertialWindow, WithoutImagesTheCovarianceGrowsAndHoldsTheError) {
  Drive drive({}, FewLandmarks());
  drive.Go(20);
  const Matrix15 before = drive.window().newest().covariance;
  drive.Go(15, 0.0, true);
  const Matrix15 after = drive.window().newest().covariance;
  for (int i = 0; i < 9; ++i) EXPECT_GT(after(i, i), before(i, i)) << i;
  const Vector15 error = drive.Error();
  for (int i = 0; i < 9; ++i) EXPECT_LT(std::abs(error[i]), 4.0 * std::sqrt(after(i, i))) << i;
}

TEST(VisualInertialWindow, ContinuesFromThePriorOfAnotherWindow) {
  Drive drive({}, FewLandmarks());
  drive.Go(20);
  const InertialPrior prior = drive.window().Prior();
  MappedPlace place({});
  const VisualInertialWindow next = *VisualInertialWindow::Make(
      place.scene().calibration(), place.model(), FewLandmarks(), prior);
  const InertialPrior same = next.Prior();
  EXPECT_EQ(same.estimate.stamp, prior.estimate.stamp);
  EXPECT_LT((same.estimate.state.v_WB - prior.estimate.state.v_WB).norm(), 1e-9);
  // The map's error at the start is added.
  const Matrix15 more = same.estimate.covariance - prior.estimate.covariance;
  EXPECT_GT(more.diagonal().head<6>().minCoeff(), 0.0);
  EXPECT_LT(more.diagonal().head<3>().maxCoeff(), 2e-7);  // (0.3 mm)^2, and its rotation at 3 m
  EXPECT_NEAR(same.gravity_sigma(), prior.gravity_sigma(), 1e-4);
}

TEST(VisualInertialWindow, FindsWhereTheCameraSitsOverTenSeeds) {
  constexpr int kRuns = 10;
  constexpr double kSigma = 0.01;  // [m], [rad] of the start
  double nees = 0.0;
  Eigen::Array<double, 6, 1> sigma = Eigen::Array<double, 6, 1>::Zero();
  for (unsigned seed = 1; seed <= kRuns; ++seed) {
    Drive drive({.seed = seed}, FewLandmarks(), {.T_BC = kSigma});
    drive.Go(30);
    const InertialPrior prior = drive.window().Prior();
    ASSERT_TRUE(prior.T_BC);
    const Pose& T_BC = *prior.T_BC;
    const Pose truth = InertialScene::T_BC();
    Eigen::Matrix<double, 6, 1> error;
    error << truth.p() - T_BC.p(), so3::Log(T_BC.q().conjugate() * truth.q());
    const Eigen::MatrixXd P = prior.calibration_covariance.bottomRightCorner<6, 6>();
    nees += error.dot(P.ldlt().solve(error)) / kRuns;
    sigma += P.diagonal().array().sqrt() / kRuns;
  }
  RecordProperty("nees", std::to_string(nees));
  EXPECT_LT(sigma.tail<3>().maxCoeff(), 0.3 * kSigma) << sigma.transpose();
  EXPECT_LT(sigma.head<3>().maxCoeff(), 0.8 * kSigma) << sigma.transpose();
  EXPECT_NEAR(nees, 6.0, 4.0 * std::sqrt(2.0 * 6.0 / kRuns));  // chi-squared of six
}

TEST(VisualInertialWindow, FindsWhereTheCameraSitsWithAClockThatIsKnown) {
  InertialOptions options = FewLandmarks();
  options.estimate_time_offset = false;
  Drive drive({}, options, {.t_d = 1e-9, .T_BC = 0.01});
  drive.Go(20);
  const InertialPrior prior = drive.window().Prior();
  const Pose error = InertialScene::T_BC().Inverse() * *prior.T_BC;
  const Eigen::Vector3d sigma = prior.calibration_covariance.diagonal().tail<3>().cwiseSqrt();
  EXPECT_LT(sigma.maxCoeff(), 0.4 * 0.01) << sigma.transpose();  // [rad]
  EXPECT_LT(error.Angle(), 3.0 * sigma.norm());
}

TEST(VisualInertialWindow, AddsNothingWhenItIsStopped) {
  Drive drive({}, {});
  drive.Go(2);
  const Stamp newest = drive.window().newest().stamp;
  EXPECT_FALSE(drive.GoWithStop());
  EXPECT_EQ(drive.window().newest().stamp, newest);
}

}  // namespace
}  // namespace highwall::visual_inertial_window_test
