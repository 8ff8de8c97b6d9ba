
#include <random>

#include <gtest/gtest.h>
#include <Eigen/Eigenvalues>

#include <highwall/frontend/inertial/visual_pose.h>

#include "support/synthetic_scene.h"
#include "tracking/tracker.h"

namespace highwall::visual_pose_test {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

const Pose kPose = Pose::FromTangent({1, 2, 3}, {0.1, -0.4, 0.3});
// The landmarks' covariance is used as it is, and the common noise is almost zero.
const VisualNoise kExact{.position = 1e-5, .rotation = 1e-5, .scale = 1.0, .min_error = 1e-6};

// Returns a positive definite matrix, of some tenths of a millimetre and of a milliradian.
Matrix6 RandomInformation(unsigned seed) {
  std::mt19937 rng(seed);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  Matrix6 A;
  for (int i = 0; i < 36; ++i) A.data()[i] = uniform(rng);
  return 1e7 * (A * A.transpose() + 0.1 * Matrix6::Identity());
}

Matrix6 Information(const VisualPose& visual) {
  return visual.sqrt_information.transpose() * visual.sqrt_information;
}

TEST(VisualPose, KeepsInformationOfFullRank) {
  const Matrix6 information = RandomInformation(1);
  const VisualPose visual = MakeVisualPose(kPose, information, Vector6::Zero(), 1.0, kExact);
  EXPECT_TRUE(visual.T_WC.Matrix().isApprox(kPose.Matrix(), 1e-15));
  const Matrix6 covariance = information.inverse() + 1e-10 * Matrix6::Identity();
  EXPECT_TRUE(Information(visual).isApprox(covariance.inverse(), 1e-9));
}

TEST(VisualPose, MovesToWhereTheGradientVanishes) {
  const Matrix6 information = RandomInformation(2);
  Vector6 step;
  step << 1e-3, -2e-3, 5e-4, 1e-4, 2e-4, -3e-4;
  // The gradient is that of the cost |r|^2 / 2 whose minimum is one step away.
  const Vector6 gradient = -information * step;
  for (const double error : {0.1, 1.0, 7.0}) {
    const VisualPose visual = MakeVisualPose(kPose, information, gradient, error, kExact);
    EXPECT_TRUE(visual.T_WC.Matrix().isApprox(kPose.Plus(step).Matrix(), 1e-10)) << error;
  }
}

// A prediction as certain as the image biases the pose of a frame away from the image's optimum.
TEST(VisualPose, OfATrackedFrameForgetsThePrediction) {
  using testing::IdealSensor;
  const testing::Scene scene = testing::MakeScene(15, 500, 40);
  testing::SceneMap scene_map(scene);
  const MeasurementModel model(IdealSensor(), {});
  const auto look = [&](const Pose& T_WC) { return testing::Look(scene, IdealSensor(), T_WC); };
  const Pose T_first = Pose::FromTangent({-0.1, 0, -0.4}, {0, 0, 0});
  const Pose truth = Pose::FromTangent({-0.09, 0.01, -0.4}, {0, 0.01, 0});
  TrackedFrame first;
  first.frame = testing::MakeFrame(look(T_first), 0);
  first.T_WC = T_first;
  const KeyFrameId id = scene_map.Add(look(T_first), T_first);
  const SensorModel sensor(model, {});
  Tracker tracker(model, {}, sensor);
  tracker.Anchor(first, *scene_map.map.keyframe(id));
  const PoseConstraint predicted{truth.Plus((Vector6() << 4e-3, -4e-3, 4e-3, 0, 0, 0).finished()),
                                 3e3 * Matrix6::Identity()};
  const TrackedFrame tracked =
      tracker.Track(testing::MakeFrame(look(truth), 1), scene_map.map, predicted).frame;
  ASSERT_EQ(tracked.state, TrackingState::kTracking);
  const double drawn = testing::PositionError(tracked.T_WC, truth);
  EXPECT_GT(drawn, 5e-4);
  const VisualPose visual =
      MakeVisualPose(tracked.T_WC, tracked.information, tracked.gradient, 1.0, kExact);
  // The features are exact; one step leaves the nonlinear error over a few millimetres.
  EXPECT_LT(testing::PositionError(visual.T_WC, truth), 0.02 * drawn);
}

TEST(VisualPose, MovesWithTheWorld) {
  const VisualPose visual =
      MakeVisualPose(kPose, RandomInformation(3), Vector6::Zero(), 1.0, kExact);
  const Pose T = Pose::FromTangent({0.3, -0.5, 2.0}, {0.2, 0.7, -0.4});
  const VisualPose moved = Moved(visual, T);
  EXPECT_TRUE(moved.T_WC.Matrix().isApprox((T * visual.T_WC).Matrix(), 1e-14));
  // The residual of a pose that moved along is unchanged.
  Vector6 step;
  step << 1e-3, -2e-3, 5e-4, 1e-4, 2e-4, -3e-4;
  Vector6 moved_step = step;
  moved_step.head<3>() = T.R() * step.head<3>();
  EXPECT_TRUE(
      (T * visual.T_WC.Plus(step)).Matrix().isApprox(moved.T_WC.Plus(moved_step).Matrix(), 1e-14));
  EXPECT_TRUE((moved.sqrt_information * moved_step).isApprox(visual.sqrt_information * step, 1e-9));
}

TEST(VisualPose, AnOpenDirectionStaysOpenAndUnmoved) {
  // The direction u, across positions and rotations, has no information.
  Vector6 u;
  u << 0.6, 0.0, -0.3, 0.1, 0.5, 0.2;
  u.normalize();
  const Matrix6 P = Matrix6::Identity() - u * u.transpose();
  const Matrix6 information = P * RandomInformation(3) * P;
  Vector6 gradient = P * Vector6::Constant(10.0);
  const VisualPose visual = MakeVisualPose(kPose, information, gradient, 1.0, kExact);
  EXPECT_LT((visual.sqrt_information * u).norm(), 1e-6 * visual.sqrt_information.norm());
  EXPECT_TRUE(Information(visual).isApprox(information, 0.01));
  Vector6 step;
  step << visual.T_WC.p() - kPose.p(), Eigen::Vector3d::Zero();
  const Eigen::Quaterniond turn = kPose.q().conjugate() * visual.T_WC.q();
  step.tail<3>() = 2.0 * turn.vec();  // some 1e-4 rad
  EXPECT_LT((information * step + gradient).norm(), 1e-4 * gradient.norm()) << "the others do";
  EXPECT_LT(std::abs(u.dot(step)), 1e-6 * step.norm() + 1e-12);
}

TEST(VisualPose, WithoutKnowledgeThereIsNoInformation) {
  const VisualPose visual = MakeVisualPose(kPose, Matrix6::Zero(), Vector6::Zero());
  EXPECT_EQ(visual.sqrt_information.norm(), 0.0);
  EXPECT_TRUE(visual.T_WC.Matrix().isApprox(kPose.Matrix(), 1e-15));
}

TEST(VisualPose, NoNumberOfLandmarksIsMoreCertainThanTheCommonNoise) {
  const VisualNoise noise{.position = 1e-3, .rotation = 2e-4};
  const VisualPose visual =
      MakeVisualPose(kPose, 1e14 * Matrix6::Identity(), Vector6::Zero(), 1.0, noise);
  const Matrix6 covariance = Information(visual).inverse();
  for (int i = 0; i < 6; ++i) {
    const double floor = i < 3 ? 1e-3 : 2e-4;
    EXPECT_GE(covariance(i, i), floor * floor);
    EXPECT_LT(covariance(i, i), 1.001 * floor * floor);
  }
}

TEST(VisualPose, CommonNoiseAddsToTheCovariance) {
  const VisualNoise noise{.position = 1e-3, .rotation = 2e-4, .scale = 1.0, .min_error = 0.02};
  const Matrix6 information = RandomInformation(4);
  const VisualPose visual = MakeVisualPose(kPose, information, Vector6::Zero(), 1.0, noise);
  Vector6 common;
  common << 1e-6, 1e-6, 1e-6, 4e-8, 4e-8, 4e-8;
  Matrix6 covariance = information.inverse();
  covariance += common.asDiagonal();
  EXPECT_TRUE(Information(visual).inverse().isApprox(covariance, 1e-9));
}

TEST(VisualPose, TheFitOfTheLandmarksScalesTheirCovariance) {
  const Matrix6 information = RandomInformation(5);
  const auto scaled = [&](double error, double scale) {
    const VisualNoise noise{.position = 1e-6, .rotation = 1e-6, .scale = scale, .min_error = 0.02};
    return Information(MakeVisualPose(kPose, information, Vector6::Zero(), error, noise));
  };
  EXPECT_TRUE(scaled(4.0, 1.0).isApprox(information / 4.0, 1e-3));
  EXPECT_TRUE(scaled(0.5, 3.0).isApprox(information / 1.5, 1e-3));
  // Three landmarks that happen to fit exactly are weak evidence.
  EXPECT_TRUE(scaled(0.0, 1.0).isApprox(information / 0.02, 0.02));
}

}  // namespace
}  // namespace highwall::visual_pose_test
