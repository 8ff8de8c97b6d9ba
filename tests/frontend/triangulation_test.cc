#include <cmath>
#include <memory>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include <highwall/frontend/local/triangulation.h>

#include "local/depthless_landmarks.h"
#include "map/epipolar_matcher.h"
#include "support/synthetic_scene.h"

namespace highwall::triangulation_test {
namespace {

using testing::IdealSensor;
using testing::Look;
using testing::MakeScene;
using testing::Scene;
using testing::SyntheticView;

const MeasurementModel kModel{IdealSensor(), {}};

Pose At(double x) {
  return Pose::FromTangent({x, 0.05 * x, 0.0}, {0.0, -0.2 * x, 0.0});
}

PointView View(const Eigen::Vector3d& p_W, const Pose& T_WC, const Eigen::Vector2d& noise = {0, 0},
               int octave = 0) {
  PointFeature feature;
  feature.uv = kModel.camera().Project(T_WC.Inverse() * p_W) + noise;
  feature.octave = octave;
  return {T_WC, feature};
}

TEST(TriangulatePoint, IsExactWithoutNoise) {
  const Eigen::Vector3d p_W(0.3, -0.2, 3.0);
  const std::vector<PointView> views{View(p_W, At(0.0)), View(p_W, At(0.2)), View(p_W, At(0.5))};
  const auto point = TriangulatePoint(kModel, views);
  ASSERT_TRUE(point);
  EXPECT_LT((point->p_W - p_W).norm(), 1e-9);  // the start is exact as well
  EXPECT_LT(point->squared_error, 1e-12);
}

TEST(TriangulatePoint, IsWithinItsCovariance) {
  std::mt19937 rng(5);
  std::normal_distribution<double> normal;
  constexpr int kSeeds = 200;
  double position = 0.0, residual = 0.0;
  for (int seed = 0; seed < kSeeds; ++seed) {
    const Eigen::Vector3d p_W = testing::UniformInBox(rng, {-0.8, -0.6, 2.0}, {0.8, 0.6, 4.0});
    std::vector<PointView> views;
    for (int i = 0; i < 4; ++i) {
      const int octave = i % 3;
      const double sigma = kModel.PointSigma(octave);
      views.push_back(
          View(p_W, At(0.15 * i), sigma * Eigen::Vector2d(normal(rng), normal(rng)), octave));
    }
    const auto point = TriangulatePoint(kModel, views);
    ASSERT_TRUE(point) << seed;
    const Eigen::Vector3d error = point->p_W - p_W;
    position += error.dot(point->covariance.llt().solve(error));
    residual += point->squared_error;
  }
  // Sums of chi-square of 3 and of 8 - 3 degrees of freedom, within three standard deviations; the
  // curvature of the projection adds a few percent.
  EXPECT_NEAR(position / kSeeds, 3.0, 3.0 * std::sqrt(6.0 / kSeeds) + 0.1);
  EXPECT_NEAR(residual / kSeeds, 5.0, 3.0 * std::sqrt(10.0 / kSeeds) + 0.1);
}

TEST(TriangulatePoint, DepthOfAViewCounts) {
  const Eigen::Vector3d p_W(0.1, 0.1, 2.0);
  std::vector<PointView> views{View(p_W, At(0.0)), View(p_W, At(0.05))};
  const auto without = TriangulatePoint(kModel, views);
  views[0].feature.depth = 2.0;
  views[0].feature.depth_sigma = 0.01;
  const auto with = TriangulatePoint(kModel, views);
  ASSERT_TRUE(without && with);
  EXPECT_GT(std::sqrt(without->covariance(2, 2)), 0.03);
  EXPECT_LT(std::sqrt(with->covariance(2, 2)), 0.011);
}

TEST(TriangulatePoint, NeedsRaysThatMeetBeforeTheCameras) {
  const Eigen::Vector3d p_W(0.1, 0.1, 2.0);
  EXPECT_FALSE(TriangulatePoint(kModel, std::vector{View(p_W, At(0.0)), View(p_W, At(0.0))}))
      << "one ray twice";
  // The cameras converge, from the left and the right, so that the rays meet behind them.
  PointView left = View(p_W, At(0.0)), right = View(p_W, At(0.5));
  std::swap(left.T_WC, right.T_WC);
  EXPECT_FALSE(TriangulatePoint(kModel, std::vector{left, right}));
}

class EpipolarMatcherTest : public ::testing::Test {
 protected:
  // Matches features that see the scene's points in the same order.
  std::vector<std::pair<int, int>> Match(const SyntheticView& a, const Pose& T_WA,
                                         const SyntheticView& b, const Pose& T_WB) {
    const std::vector<bool> all_a(a.points.size(), true), all_b(b.points.size(), true);
    return MatchEpipolar(kModel, {*a.features, T_WA, all_a}, {*b.features, T_WB, all_b}, {});
  }
  const Scene scene = MakeScene(7, 200, 0);
};

TEST_F(EpipolarMatcherTest, FindsTheSamePointsWithoutTheirDepth) {
  const SyntheticView a = Look(scene, IdealSensor(), At(0.0), {.px = 0.3});
  const SyntheticView b = Look(scene, IdealSensor(), At(0.3), {.px = 0.3, .seed = 2});
  const auto pairs = Match(a, At(0.0), b, At(0.3));
  EXPECT_GT(pairs.size(), 100U);
  for (const auto& [i, j] : pairs) {
    EXPECT_EQ(a.points[static_cast<std::size_t>(i)], b.points[static_cast<std::size_t>(j)]);
  }
}

TEST_F(EpipolarMatcherTest, DoesNotPairPointsOffTheEpipolarLineOrExcludedOnes) {
  const SyntheticView a = Look(scene, IdealSensor(), At(0.0));
  SyntheticView b = Look(scene, IdealSensor(), At(0.3));
  const auto before = Match(a, At(0.0), b, At(0.3));
  auto moved = std::make_shared<FrameFeatures>(*b.features);
  // The cameras are side by side: epipolar lines are along the rows, and 20 px exceed any level's
  // noise.
  for (PointFeature& feature : moved->points) feature.uv.y() += 20.0;
  b.features = moved;
  EXPECT_LT(Match(a, At(0.0), b, At(0.3)).size(), before.size() / 10);
  const std::vector<bool> none(a.points.size(), false), all(b.points.size(), true);
  EXPECT_TRUE(
      MatchEpipolar(kModel, {*a.features, At(0.0), none}, {*b.features, At(0.3), all}, {}).empty());
  EXPECT_TRUE(Match(a, At(0.0), a, At(0.0)).empty()) << "no base, no line";
}

// Keyframes side by side whose corners have no depth.
class DepthlessPointsTest : public ::testing::Test {
 protected:
  void Add(double x, unsigned seed, double px = 0.3) {
    const SyntheticView view = Look(scene, IdealSensor(), At(x), {.px = px, .seed = seed});
    auto features = std::make_shared<FrameFeatures>(*view.features);
    for (PointFeature& feature : features->points) feature.depth = feature.depth_sigma = 0.0;
    Frame frame;
    frame.features = features;
    ids.push_back(map.AddKeyFrame(frame, At(x)).id);
    seen.push_back(view.points);
  }
  std::vector<Depthless<MapPoint>> Find(const TriangulationOptions& options = {}) const {
    return FindDepthlessPoints(kModel, map, ids.back(), std::span(ids).first(ids.size() - 1),
                               options, InlierBounds());
  }

  const Scene scene = MakeScene(9, 200, 0);
  Map map;
  std::vector<KeyFrameId> ids;
  std::vector<std::vector<int>> seen;  // the scene's point, by keyframe and feature
};

TEST_F(DepthlessPointsTest, AreThoseThatSeveralKeyFramesSeeWithParallax) {
  Add(0.0, 1);
  Add(0.2, 2);
  Add(0.4, 3);
  const auto found = Find({.min_views = 3, .max_depth_sigma = 0.05});
  EXPECT_GT(found.size(), 60U);
  for (const Depthless<MapPoint>& point : found) {
    ASSERT_EQ(point.observations.size(), 3U);
    EXPECT_EQ(point.observations.front().keyframe, ids.back());
    const auto index = static_cast<std::size_t>(point.observations.front().index);
    const Eigen::Vector3d truth = scene.points[static_cast<std::size_t>(seen[2][index])].p_W;
    // The bound is four times the largest depth error that is allowed.
    EXPECT_LT((point.geometry_W - truth).norm(), 4.0 * 0.05 * truth.norm());
  }
}

TEST_F(DepthlessPointsTest, WaitForParallaxAndForAThirdView) {
  Add(0.0, 1);
  Add(0.01, 2);
  Add(0.02, 3);
  EXPECT_TRUE(Find({.min_views = 3, .max_depth_sigma = 0.05}).empty()) << "no parallax yet";
  Map two_views;
  std::swap(map, two_views);
  ids.clear();
  seen.clear();
  Add(0.0, 1);
  Add(0.4, 2);
  EXPECT_TRUE(Find({.min_views = 3}).empty());
  EXPECT_GT(Find({.min_views = 2}).size(), 60U);
}

TEST_F(DepthlessPointsTest, LeavesOutAViewThatContradictsThePoint) {
  Add(0.0, 1);
  Add(0.2, 2);
  Add(0.3, 3);
  Add(0.4, 4);
  EXPECT_GT(Find({.min_views = 4}).size(), 40U);
  // The pose of one keyframe is wrong along the epipolar lines, where matching cannot detect it.
  map.keyframe(ids[1])->T_WC = Pose::FromTangent({0.1, 0.005, 0}, {0, 0, 0}) * At(0.2);
  EXPECT_TRUE(Find({.min_views = 4}).empty());
  const auto found = Find({.min_views = 3});
  EXPECT_GT(found.size(), 40U);
  for (const Depthless<MapPoint>& point : found) {
    for (const Observation& o : point.observations) EXPECT_NE(o.keyframe, ids[1]);
  }
}

}  // namespace
}  // namespace highwall::triangulation_test
