#include "map/relative_information.h"

#include <gtest/gtest.h>
#include <Eigen/Eigenvalues>

#include <highwall/core/error.h>
#include <highwall/core/so3.h>
#include <highwall/frontend/local/bundle_adjustment.h>

#include "support/id_literals.h"
#include "support/synthetic_scene.h"

namespace highwall::relative_information_test {
namespace {

using testing::IdealSensor;
using testing::Look;
using testing::MakeScene;
using testing::Scene;
using testing::SceneMap;
using testing::operator""_kf;

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

const Pose kStart = Pose::FromTangent({0.1, 0.2, 0.0}, {0.02, 0.0, 0.1});
const Pose kEnd = Pose::FromTangent({0.4, 0.1, 0.1}, {0.0, -0.05, 0.02});

// Two keyframes of a scene.
class Pair {
 public:
  explicit Pair(const Scene& scene, const testing::ViewNoise& noise = {}) : scene_map_(scene) {
    testing::ViewNoise later = noise;
    later.seed += 1000;
    scene_map_.Add(Look(scene, IdealSensor(), kStart, noise), kStart);
    scene_map_.Add(Look(scene, IdealSensor(), kEnd, later), kEnd);
  }
  Map& map() { return scene_map_.map; }
  const MeasurementModel& model() const { return model_; }
  Matrix6 Information() { return RelativeInformation(map(), model_, 0_kf, 1_kf); }

 private:
  const MeasurementModel model_{IdealSensor(), {}};
  SceneMap scene_map_;
};

// Returns e^T I e of the relative pose in a map that is adjusted to noisy observations.
double NormalizedErrorOf(const Scene& scene, unsigned seed) {
  Pair pair(scene, {.px = MeasurementOptions().point_sigma, .depth = true, .seed = seed});
  const KeyFrameId first[] = {0_kf}, second[] = {1_kf};
  // No observation is an outlier.
  const BundleAdjustmentOptions all{.point_huber = 1e3,
                                    .inliers = {.chi2_2 = 1e6, .chi2_3 = 1e6},
                                    .first_iterations = 20,
                                    .tolerance = 1e-9,
                                    .trust_region = 1e8};
  EXPECT_TRUE(AdjustBundle(pair.map(), pair.model(), second, first, all).usable);
  const Pose E = kEnd.Inverse() * pair.map().keyframe(1_kf)->T_WC;
  Vector6 e;
  e << E.p(), so3::Log(E.q());
  return e.dot(pair.Information() * e);
}

double MeanOverFiftyDraws(int points) {
  double sum = 0.0;
  for (unsigned seed = 1; seed <= 50; ++seed) {
    sum += NormalizedErrorOf(MakeScene(seed, points, 0), seed);
  }
  return sum / 50.0;
}

// The mean of fifty squares of six degrees of freedom is 6 with a sigma of sqrt(12 / 50) = 0.49: 95
// % of the means lie between 5.04 and 6.96.
constexpr double kBand = 0.96;

TEST(RelativeInformation, IsThatOfTheAdjustedPose) {
  EXPECT_NEAR(MeanOverFiftyDraws(200), 6.0, kBand);
}

TEST(RelativeInformation, IsThatOfTheAdjustedPoseWhereLandmarksAreFew) {
  EXPECT_NEAR(MeanOverFiftyDraws(12), 6.0, kBand);
}

TEST(RelativeInformation, GrowsWithTheLandmarks) {
  Pair few(MakeScene(3, 20, 5)), many(MakeScene(3, 200, 50));
  const Matrix6 gain = many.Information() - few.Information();
  EXPECT_GT(Eigen::SelfAdjointEigenSolver<Matrix6>(gain).eigenvalues().minCoeff(), 0.0);
}

TEST(RelativeInformation, OneLineLeavesTheMotionAlongItOpen) {
  Scene scene;
  scene.lines.push_back(
      {Segment3(Eigen::Vector3d(-0.5, 0.1, 3.0), Eigen::Vector3d(0.5, 0.2, 3.1)), {}});
  Pair pair(scene);
  const Matrix6 information = pair.Information();
  const Segment3& segment = scene.lines[0].segment_W;
  Vector6 along = Vector6::Zero(), across = Vector6::Zero();
  along.head<3>() = kEnd.R().transpose() * (segment.q() - segment.p()).normalized();
  across.head<3>() = kEnd.R().transpose() * Eigen::Vector3d::UnitY();
  // The depths at both ends are of one line, up to the rounding of its float pixels.
  EXPECT_LT(along.dot(information * along), 1e-3 * across.dot(information * across));
  EXPECT_GT(across.dot(information * across), 1e4);  // better than a centimetre
}

TEST(RelativeInformation, IsNoneWithoutCommonLandmarks) {
  Pair pair(MakeScene(3, 60, 10));
  ForEachKind([&]<class Landmark>() {
    const LandmarkIds<Landmark> ids = PartOf<Landmark>(*pair.map().keyframe(1_kf));
    for (const Id<Landmark> id : ids) {
      if (id != kNoId) pair.map().Forget(1_kf, id);
    }
  });
  EXPECT_TRUE(pair.Information().isZero(0.0));
}

TEST(RelativeInformation, ThrowsForAKeyFrameThatIsNotInTheMap) {
  Pair pair(MakeScene(3, 20, 0));
  EXPECT_THROW(RelativeInformation(pair.map(), pair.model(), 0_kf, 7_kf), InvalidArgument);
}

}  // namespace
}  // namespace highwall::relative_information_test
