#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <highwall/core/error.h>
#include <highwall/frontend/local/triangulation.h>

#include "local/depthless_landmarks.h"
#include "map/epipolar_line_matcher.h"
#include "support/synthetic_scene.h"

namespace highwall::line_triangulation_test {
namespace {

using testing::IdealSensor;
using testing::Look;
using testing::MakeScene;
using testing::Scene;
using testing::SyntheticView;

const MeasurementModel kModel{IdealSensor(), {}};

// The camera moves right and down at the same time, so that few lines lie along its path.
Pose At(double x) {
  return Pose::FromTangent({x, 0.5 * x * x, 0.1 * x}, {0.0, -0.15 * x, 0.0});
}

Eigen::Vector2d Pixel(const Pose& T_WC, const Eigen::Vector3d& p_W) {
  return kModel.camera().Project(T_WC.Inverse() * p_W);
}

// Returns the view of a segment between the fractions `from` and `to` of its length; noise: [px]
// across the segment, at either end.
LineView View(const Segment3& segment_W, const Pose& T_WC,
              const Eigen::Vector2d& noise = Eigen::Vector2d::Zero(), double from = 0.0,
              double to = 1.0) {
  const Eigen::Vector3d p = segment_W.p(), d = segment_W.q() - p;
  const Eigen::Vector2d s = Pixel(T_WC, p + from * d), e = Pixel(T_WC, p + to * d);
  const Eigen::Vector2d along = (e - s).normalized(), across(-along.y(), along.x());
  return {T_WC, {(s + noise[0] * across).cast<float>(), (e + noise[1] * across).cast<float>()}};
}

// Returns the true line in the parameters of the view: LineInView's offsets and inverse depths.
Eigen::Vector4d Truth(const Segment3& segment_W, const LineView& view) {
  const PluckerLine line =
      view.T_WC.Inverse() * PluckerLine::FromPoints(segment_W.p(), segment_W.q());
  const Eigen::Vector2d d = (view.segment.e - view.segment.s).cast<double>().normalized();
  const PinholeCamera& camera = kModel.camera();
  const Eigen::Vector3d across(-d.y() / camera.fx, d.x() / camera.fy, 0.0);
  Eigen::Vector4d truth;
  for (const int i : {0, 1}) {
    const Eigen::Vector2f& end = i == 0 ? view.segment.s : view.segment.e;
    const Eigen::Vector3d ray = camera.Unproject(end.cast<double>(), 1.0);
    truth[i] = -line.n.dot(ray) / line.n.dot(across);
    const Eigen::Vector3d on_line = ray + truth[i] * across;
    truth[2 + i] = on_line.dot(line.d.cross(line.n)) / line.n.squaredNorm();
  }
  return truth;
}

Eigen::Vector4d Numbers(const LineInView& line) {
  Eigen::Vector4d x;
  x << line.offset, line.inverse_depth;
  return x;
}

Segment3 RandomSegment(std::mt19937& rng) {
  const Eigen::Vector3d p = testing::UniformInBox(rng, {-0.6, -0.5, 2.0}, {0.6, 0.5, 3.5});
  // The lines are more vertical than horizontal, because the camera moves to the right.
  const Eigen::Vector3d d = testing::UniformInBox(rng, {-0.3, 0.4, -0.3}, {0.3, 0.9, 0.3});
  return {p, p + d};
}

TEST(TriangulateLine, IsExactWithoutNoise) {
  const Segment3 segment({0.3, -0.2, 3.0}, {0.1, 0.4, 2.5});
  // The third view sees only a part of it.
  const std::vector<LineView> views{View(segment, At(0.0)), View(segment, At(0.2)),
                                    View(segment, At(0.5), {0, 0}, 0.3, 1.2)};
  const auto line = TriangulateLine(kModel, views);
  ASSERT_TRUE(line);
  // Pixels are floats, of 3e-5 px, and a pixel of this base is 1 cm.
  EXPECT_LT((line->segment_W.p() - segment.p()).norm(), 1e-5);
  EXPECT_LT((line->segment_W.q() - segment.q()).norm(), 1e-5);
  EXPECT_LT((Numbers(line->seen) - Truth(segment, views.front())).norm(), 1e-4);
  for (const double error : line->squared_errors) EXPECT_LT(error, 1e-8);
}

TEST(TriangulateLine, IsWithinItsCovariance) {
  std::mt19937 rng(5);
  std::normal_distribution<double> normal(0.0, kModel.options().line_sigma);
  constexpr int kSeeds = 200;
  double line_error = 0.0, residual = 0.0;
  for (int seed = 0; seed < kSeeds; ++seed) {
    const Segment3 segment = RandomSegment(rng);
    std::vector<LineView> views;
    for (int i = 0; i < 4; ++i) {
      const double a = normal(rng), b = normal(rng);
      views.push_back(View(segment, At(0.2 * i), {a, b}, 0.05 * i, 1.0 - 0.1 * i));
    }
    const auto line = TriangulateLine(kModel, views);
    ASSERT_TRUE(line) << seed;
    const Eigen::Vector4d error = Numbers(line->seen) - Truth(segment, views.front());
    line_error += error.dot(line->seen.covariance.llt().solve(error));
    for (const double r2 : line->squared_errors) residual += r2;
  }
  // Sums of chi-square of 4 and of 2 x 4 - 4 degrees of freedom, within three standard deviations;
  // the curvature of the projection adds a few percent.
  EXPECT_NEAR(line_error / kSeeds, 4.0, 3.0 * std::sqrt(8.0 / kSeeds) + 0.1);
  EXPECT_NEAR(residual / kSeeds, 4.0, 3.0 * std::sqrt(8.0 / kSeeds) + 0.1);
}

TEST(TriangulateLine, HasTheRowsOfTheAdjustment) {
  const Segment3 segment({0.3, -0.2, 3.0}, {0.1, 0.4, 2.5});
  const std::vector<LineView> views{View(segment, At(0.0), {1.0, -0.5}),
                                    View(segment, At(0.2), {0.4, 0.8}),
                                    View(segment, At(0.5), {-0.7, 0.2})};
  const auto line = TriangulateLine(kModel, views);
  ASSERT_TRUE(line);
  const OrthonormalLine line_W(PluckerLine::FromPoints(line->segment_W.p(), line->segment_W.q()));
  for (std::size_t i = 0; i < views.size(); ++i) {
    const auto factor = kModel.MakeFactor(LineFeature{views[i].segment, {}});
    const double* blocks[] = {views[i].T_WC.data(), line_W.data()};
    Eigen::Vector2d r;
    ASSERT_TRUE(factor->Evaluate(blocks, r.data(), nullptr));
    EXPECT_NEAR(line->squared_errors[i], r.squaredNorm(), 1e-9) << i;  // double precision
  }
}

TEST(TriangulateLine, WeighsAViewByItsOwnNoise) {
  const Segment3 segment({0.3, -0.2, 3.0}, {0.1, 0.4, 2.5});
  std::vector<LineView> views{View(segment, At(0.0)), View(segment, At(0.2)),
                              View(segment, At(0.5))};
  const auto one = TriangulateLine(kModel, views);
  ASSERT_TRUE(one);
  for (LineView& view : views) view.sigma *= 0.5;
  const auto half = TriangulateLine(kModel, views);
  ASSERT_TRUE(half);
  // Both have one optimum, up to the float precision of the pixels.
  EXPECT_TRUE(half->seen.covariance.isApprox(0.25 * one->seen.covariance, 1e-4));
  // The view that is far off is also the noisy one: the line stays with the others.
  views.push_back(View(segment, At(0.7), {6.0, 6.0}));
  views.back().sigma = 1e3;
  const auto with_noisy = TriangulateLine(kModel, views);
  ASSERT_TRUE(with_noisy);
  EXPECT_LT((with_noisy->segment_W.p() - one->segment_W.p()).norm(), 1e-4);
  EXPECT_LT((with_noisy->segment_W.q() - one->segment_W.q()).norm(), 1e-4);
}

// The planes through the cameras and the observed segments almost coincide: only noise determines a
// distance.
TEST(TriangulateLine, FindsNoDistanceWhereTheCameraMovesInThePlaneOfTheLine) {
  const Segment3 segment({-0.4, 0.2, 2.5}, {0.5, 0.2, 2.2});
  // The camera moves along the line and towards it, while it rotates.
  const auto in_plane = [&](double x) {
    const Eigen::Vector3d way = x * (segment.q() - segment.p()) + 0.1 * x * segment.p();
    return Pose::FromTangent(way, {0.05 * x, 0.1 * x, 0.2 * x});
  };
  std::mt19937 rng(8);
  std::normal_distribution<double> normal(0.0, kModel.options().line_sigma);
  int found = 0;
  for (int seed = 0; seed < 50; ++seed) {
    std::vector<LineView> views;
    for (const double x : {0.0, 0.15, 0.3, 0.45}) {
      const double a = normal(rng), b = normal(rng);
      views.push_back(View(segment, in_plane(x), {a, b}));
    }
    const auto line = TriangulateLine(kModel, views);
    if (!line) continue;
    ++found;
    const Eigen::Array2d sigma = line->seen.covariance.diagonal().tail<2>().array().sqrt();
    EXPECT_GT((sigma / line->seen.inverse_depth.array()).maxCoeff(), 0.2) << seed;
  }
  EXPECT_GE(found, 5) << "else nothing was judged";
  const std::vector<LineView> one_place(3, View(segment, At(0.0)));
  EXPECT_FALSE(TriangulateLine(kModel, one_place));
}

TEST(TriangulateLine, NeedsALineBeforeTheCamerasAndTwoViews) {
  const Segment3 segment({0.1, -0.3, 2.0}, {0.1, 0.3, 2.0});
  LineView left = View(segment, At(0.0)), right = View(segment, At(0.5));
  EXPECT_TRUE(TriangulateLine(kModel, std::vector{left, right}));
  // The cameras converge, from the left and the right, so that the planes meet behind them.
  std::swap(left.T_WC, right.T_WC);
  EXPECT_FALSE(TriangulateLine(kModel, std::vector{left, right}));
  EXPECT_THROW(TriangulateLine(kModel, std::vector{left}), InvalidArgument);
}

class EpipolarLineMatcherTest : public ::testing::Test {
 protected:
  std::vector<std::pair<int, int>> Match(const SyntheticView& a, const Pose& T_WA,
                                         const SyntheticView& b, const Pose& T_WB) {
    const std::vector<bool> all_a(a.lines.size(), true), all_b(b.lines.size(), true);
    return MatchEpipolarLines(kModel, {*a.features, T_WA, all_a}, {*b.features, T_WB, all_b},
                              InlierBounds().Of(1));
  }
  const Scene scene = MakeScene(7, 0, 80);
};

TEST_F(EpipolarLineMatcherTest, FindsTheSameLinesWithoutTheirDepth) {
  const SyntheticView a = Look(scene, IdealSensor(), At(0.0), {.px = 0.3});
  const SyntheticView b = Look(scene, IdealSensor(), At(0.3), {.px = 0.3, .seed = 2});
  const auto pairs = Match(a, At(0.0), b, At(0.3));
  EXPECT_GT(pairs.size(), 30U);
  for (const auto& [i, j] : pairs) {
    EXPECT_EQ(a.lines[static_cast<std::size_t>(i)], b.lines[static_cast<std::size_t>(j)]);
  }
}

TEST_F(EpipolarLineMatcherTest, DoesNotPairSegmentsThatNoDistanceExplainsOrExcludedOnes) {
  const SyntheticView a = Look(scene, IdealSensor(), At(0.0));
  SyntheticView b = Look(scene, IdealSensor(), At(0.3));
  const std::size_t before = Match(a, At(0.0), b, At(0.3)).size();
  auto turned = std::make_shared<FrameFeatures>(*b.features);
  for (LineFeature& line : turned->lines) std::swap(line.segment.s, line.segment.e);
  b.features = turned;
  EXPECT_TRUE(Match(a, At(0.0), b, At(0.3)).empty()) << "the brighter side is the other one";
  b = Look(scene, IdealSensor(), At(0.3));
  auto moved = std::make_shared<FrameFeatures>(*b.features);
  // Seen from further right, everything moves to the left.
  for (LineFeature& line : moved->lines) {
    line.segment.s.x() += 250.0F;
    line.segment.e.x() += 250.0F;
  }
  b.features = moved;
  EXPECT_LT(Match(a, At(0.0), b, At(0.3)).size(), before / 5);
  const std::vector<bool> none(a.lines.size(), false), all(b.lines.size(), true);
  EXPECT_TRUE(MatchEpipolarLines(kModel, {*a.features, At(0.0), none}, {*b.features, At(0.3), all},
                                 InlierBounds().Of(1))
                  .empty());
  EXPECT_TRUE(Match(a, At(0.0), a, At(0.0)).empty()) << "no base, no distance";
}

// With hardly any baseline, noise alone puts half of the segments beyond infinity, by up to its own
// amount.
TEST_F(EpipolarLineMatcherTest, ASegmentMayMissTheLineByItsNoise) {
  constexpr double kBase = 0.002;
  const auto look = [&](double x, unsigned seed, float noise) {
    SyntheticView view = Look(scene, IdealSensor(), At(x), {.px = 1.0, .seed = seed});
    auto features = std::make_shared<FrameFeatures>(*view.features);
    for (LineFeature& line : features->lines) line.noise.px = noise;
    view.features = features;
    return view;
  };
  const auto count = [&](float noise_a, float noise_b) {
    return Match(look(0.0, 1, noise_a), At(0.0), look(kBase, 2, noise_b), At(kBase)).size();
  };
  const std::size_t as_it_is = count(1.0F, 1.0F), of_none = count(0.05F, 0.05F);
  EXPECT_GT(as_it_is, 30U);
  EXPECT_LT(of_none, as_it_is / 2);
  EXPECT_GT(count(1.0F, 0.05F), of_none);
  EXPECT_GT(count(0.05F, 1.0F), of_none);
}

// Keyframes whose segments have no depth.
class DepthlessLinesTest : public ::testing::Test {
 protected:
  void Add(const Pose& T_WC, unsigned seed, bool with_depth = false) {
    const SyntheticView view = Look(scene, IdealSensor(), T_WC, {.px = 0.5, .seed = seed});
    auto features = std::make_shared<FrameFeatures>(*view.features);
    for (LineFeature& line : features->lines) {
      if (!with_depth) line.segment_C.reset();
    }
    Frame frame;
    frame.features = features;
    ids.push_back(map.AddKeyFrame(frame, T_WC).id);
    seen.push_back(view.lines);
  }
  void AddSideBySide(int count) {
    for (int i = 0; i < count; ++i) Add(At(0.2 * i), static_cast<unsigned>(i) + 1);
  }
  std::vector<Depthless<MapLine>> Find(const TriangulationOptions& options = {}) const {
    return FindDepthlessLines(kModel, map, ids.back(), std::span(ids).first(ids.size() - 1),
                              options, InlierBounds());
  }

  const Scene scene = MakeScene(9, 0, 80);
  Map map;
  std::vector<KeyFrameId> ids;
  std::vector<std::vector<int>> seen;  // the scene's line, by keyframe and segment
};

TEST_F(DepthlessLinesTest, AreThoseThatSeveralKeyFramesSeeWithParallax) {
  AddSideBySide(4);
  const auto found = Find({.max_depth_sigma = 0.03});
  EXPECT_GT(found.size(), 20U);
  for (const Depthless<MapLine>& line : found) {
    ASSERT_GE(line.observations.size(), 3U);
    EXPECT_EQ(line.observations.front().keyframe, ids.back());
    const auto index = static_cast<std::size_t>(line.observations.front().index);
    const Segment3& truth = scene.lines[static_cast<std::size_t>(seen[3][index])].segment_W;
    const PluckerLine line_W = PluckerLine::FromPoints(truth.p(), truth.q());
    // The bound is four times the largest depth error that is allowed.
    EXPECT_LT(line_W.Distance(line.geometry_W.p()), 4.0 * 0.03 * truth.p().norm());
    EXPECT_LT(line_W.Distance(line.geometry_W.q()), 4.0 * 0.03 * truth.q().norm());
  }
}

TEST_F(DepthlessLinesTest, WaitForParallaxAndForAThirdView) {
  Add(At(0.0), 1);
  Add(At(0.4), 2);
  EXPECT_TRUE(Find().empty()) << "two planes meet in a line whatever they show";
  Add(At(0.8), 3);
  EXPECT_GT(Find().size(), 15U);
  Map near;
  std::swap(map, near);
  ids.clear();
  for (const double x : {0.0, 0.01, 0.02, 0.03}) Add(At(x), static_cast<unsigned>(100.0 * x) + 1);
  EXPECT_TRUE(Find({.max_depth_sigma = 0.05}).empty()) << "no parallax yet";
}

TEST_F(DepthlessLinesTest, SegmentsThatAreLandmarksOrHaveDepthAreNone) {
  AddSideBySide(3);
  const auto before = Find();
  ASSERT_FALSE(before.empty());
  const Observation& first = before.front().observations.front();
  map.Observe(first.keyframe, first.index, map.Add<MapLine>(before.front().geometry_W, 0).id);
  EXPECT_EQ(Find().size(), before.size() - 1);
  Add(At(0.6), 4, true);
  EXPECT_TRUE(Find().empty());
}

TEST_F(DepthlessLinesTest, LeavesOutAViewThatContradictsTheLine) {
  AddSideBySide(5);
  EXPECT_GT(Find({.min_views = 5}).size(), 5U);
  // The pose of one keyframe is wrong: it is rolled, because a line along the shift would not
  // reveal a shifted one.
  map.keyframe(ids[1])->T_WC = At(0.2) * Pose::FromTangent({0, 0, 0}, {0, 0, 0.3});
  EXPECT_TRUE(Find({.min_views = 5}).empty());
  const auto found = Find({.min_views = 4});
  EXPECT_GT(found.size(), 5U);
  for (const Depthless<MapLine>& line : found) {
    for (const Observation& o : line.observations) EXPECT_NE(o.keyframe, ids[1]);
  }
}

TEST_F(DepthlessLinesTest, AreAsCertainAsTheNoiseOfTheirSegments) {
  AddSideBySide(4);
  const std::size_t before = Find({.max_depth_sigma = 0.02}).size();
  for (const KeyFrameId id : ids) {
    auto features = std::make_shared<FrameFeatures>(*map.keyframe(id)->frame.features);
    for (LineFeature& line : features->lines) line.noise.px = 0.5F;
    map.keyframe(id)->frame.features = features;
  }
  EXPECT_GT(Find({.max_depth_sigma = 0.02}).size(), before);
}

}  // namespace
}  // namespace highwall::line_triangulation_test
