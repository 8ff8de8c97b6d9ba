// FrameResult::uncertainty against the true errors of rendered walks. Takes half a minute.
#include <highwall/core/so3.h>
#include <highwall/frontend/system/slam_system.h>

#include <cmath>
#include <map>

#include <gtest/gtest.h>
#include <simulate/scenes/room.h>
#include <Eigen/Cholesky>

#include "support/rendered_walk.h"

namespace highwall::pose_uncertainty_test {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

simulate::SimulationOptions Walk(unsigned seed) {
  simulate::SimulationOptions options;
  options.seed = seed;
  options.fps = 15.0;
  options.duration = 3.0;
  options.camera = {
      .width = 320, .height = 240, .fx = 262.5, .fy = 262.5, .cx = 159.5, .cy = 119.5};
  options.sensor.noise = simulate::SensorNoise::kKinect;
  options.imu.enabled = false;
  return options;
}

// Returns the error of a pose in the tangent of PoseUncertainty.
Vector6 ErrorOf(const Pose& estimate, const Pose& truth) {
  Vector6 e;
  e << truth.q().conjugate() * (estimate.p() - truth.p()),
      so3::Log(truth.q().conjugate() * estimate.q());
  return e;
}

double NormalizedSquare(const Vector6& e, const Matrix6& covariance) {
  return e.dot(covariance.ldlt().solve(e));
}

// Means of e^T C^-1 e, which is 6 on average if C is the covariance of the error e.
struct NormalizedErrors {
  double in_keyframe = 0.0, in_map = 0.0;
};

NormalizedErrors OfRun(unsigned seed) {
  const simulate::SimulationOptions options = Walk(seed);
  const testing::RenderedWalk walk = testing::Render(simulate::SimulateRoom(options));
  RgbdSensor sensor;
  sensor.camera = options.camera;
  SlamSystem system(sensor, Deterministic({}));
  std::map<Stamp, Pose> truth;
  for (const StampedPose& pose : walk.truth) truth[pose.stamp] = pose.pose;
  NormalizedErrors sum;
  int frames = 0;
  Pose T_map_truth;
  for (const RgbdImage& image : walk.images) {
    const FrameResult result = system.Track(image);
    if (!HasPose(result.state)) continue;
    const Pose& T_WC = truth.at(result.stamp);
    if (result.uncertainty->reference == kNoId) {
      T_map_truth = result.T_WC * T_WC.Inverse();
      continue;
    }
    const KeyFrame& reference = *system.map().keyframe(result.uncertainty->reference);
    sum.in_keyframe += NormalizedSquare(ErrorOf(reference.T_WC.Inverse() * result.T_WC,
                                                truth.at(reference.frame.stamp).Inverse() * T_WC),
                                        result.uncertainty->in_keyframe);
    sum.in_map +=
        NormalizedSquare(ErrorOf(result.T_WC, T_map_truth * T_WC), result.uncertainty->in_map);
    ++frames;
  }
  return {sum.in_keyframe / frames, sum.in_map / frames};
}

NormalizedErrors OfRuns(int runs) {
  NormalizedErrors mean;
  for (int run = 0; run < runs; ++run) {
    const NormalizedErrors of_run = OfRun(static_cast<unsigned>(run + 1));
    mean.in_keyframe += of_run.in_keyframe / runs;
    mean.in_map += of_run.in_map / runs;
  }
  return mean;
}

// The frames of a run are not independent, so that the bounds are those of one frame a run: the
// mean of `runs` chi-squared variables of 6 degrees of freedom has the variance 12 / runs.
void ExpectHonest(const NormalizedErrors& mean, int runs) {
  const double band = 1.96 * std::sqrt(12.0 / runs);
  EXPECT_NEAR(mean.in_keyframe, 6.0, band);
  // The chain of keyframes ignores what adjustments gain, so that the map is better than stated:
  // its standard deviations are at most twice the errors.
  EXPECT_LT(mean.in_map, 6.0 + band);
  EXPECT_GT(mean.in_map, 6.0 / 4.0);
}

TEST(PoseUncertaintyTest, NormalizedErrorsOfEightRunsAreInTheirBand) {
  ExpectHonest(OfRuns(8), 8);
}

TEST(PoseUncertaintyTest, NormalizedErrorsOfFiftyRunsAreInTheirBand) {
  ExpectHonest(OfRuns(50), 50);
}

}  // namespace
}  // namespace highwall::pose_uncertainty_test
