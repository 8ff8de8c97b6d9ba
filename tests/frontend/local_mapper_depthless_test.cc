// LocalMapper with corners and segments that have no depth.
#include <cstddef>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "local_mapper_fixture.h"

namespace highwall::local_mapper_depthless_test {
namespace {

using testing::At;
using testing::IdealSensor;
using testing::Look;
using testing::SyntheticView;

class LocalMapperDepthlessTest : public testing::LocalMapperTest {
 protected:
  SyntheticView LookWithoutDepthOfLines(double x) const {
    SyntheticView view = Look(scene, IdealSensor(), At(x));
    auto features = std::make_shared<FrameFeatures>(*view.features);
    for (LineFeature& line : features->lines) line.segment_C.reset();
    view.features = features;
    return view;
  }
};

TEST_F(LocalMapperDepthlessTest, CornersWithoutDepthBecomeLandmarksWhenThreeKeyFramesSeeThem) {
  LocalMapper mapper(model, {});
  std::vector<int> triangulated;
  for (const double x : {0.0, 0.25, 0.5, 0.75}) {
    SyntheticView view = Look(scene, IdealSensor(), At(x));
    auto features = std::make_shared<FrameFeatures>(*view.features);
    for (std::size_t i = 0; i < view.points.size(); ++i) {
      if (view.points[i] % 3 == 0) features->points[i].depth = features->points[i].depth_sigma = 0;
    }
    view.features = features;
    triangulated.push_back(Insert(mapper, view, At(x)).triangulated_points);
  }
  EXPECT_EQ(triangulated[0] + triangulated[1], 0) << "two views agree by chance";
  EXPECT_GT(triangulated[2], 30);
  int checked = 0;
  for (std::size_t i = 0; i < scene.points.size(); i += 3) {
    const MapPoint* point = map.Find(point_ids[i]);
    if (point == nullptr) continue;
    ++checked;
    // The features are exact: this error remains after the adjustment.
    EXPECT_LT((point->p_W - scene.points[i].p_W).norm(), 1e-3) << i;
  }
  EXPECT_GT(checked, 30);
}

TEST_F(LocalMapperDepthlessTest, SegmentsWithoutDepthBecomeLandmarksWhenThreeKeyFramesSeeThem) {
  LocalMapper mapper(model, {}, true, {.triangulation = {.scarce_points = 1000}});
  std::vector<int> triangulated;
  for (const double x : {0.0, 0.25, 0.5, 0.75}) {
    const LocalMappingReport report = Insert(mapper, LookWithoutDepthOfLines(x), At(x));
    EXPECT_EQ(report.new_lines, 0) << "from depth";
    triangulated.push_back(report.triangulated_lines);
  }
  EXPECT_EQ(triangulated[0] + triangulated[1], 0) << "two planes meet whatever they show";
  EXPECT_GT(triangulated[2], 10);
  int checked = 0;
  for (std::size_t i = 0; i < scene.lines.size(); ++i) {
    const MapLine* line = map.Find(line_ids[i]);
    if (line == nullptr) continue;
    ++checked;
    EXPECT_GE(line->observations.size(), 3U);
    EXPECT_TRUE(line->has_descriptor);
    const Segment3& truth = scene.lines[i].segment_W;
    const PluckerLine line_W = PluckerLine::FromPoints(truth.p(), truth.q());
    // The features are exact: this error remains after the adjustment.
    EXPECT_LT(line_W.Distance(line->segment_W.p()), 2e-3) << i;
    EXPECT_LT(line_W.Distance(line->segment_W.q()), 2e-3) << i;
  }
  EXPECT_GT(checked, 10);
}

TEST_F(LocalMapperDepthlessTest, WithoutTriangulationTheyMakeNone) {
  LocalMapper mapper(model, {}, true, {.triangulation = {.keyframes = 0, .scarce_points = 1000}});
  for (const double x : {0.0, 0.25, 0.5}) {
    SyntheticView view = LookWithoutDepthOfLines(x);
    auto features = std::make_shared<FrameFeatures>(*view.features);
    for (PointFeature& point : features->points) point.depth = point.depth_sigma = 0.0;
    view.features = features;
    const LocalMappingReport report = Insert(mapper, view, At(x));
    EXPECT_EQ(report.triangulated_points, 0);
    EXPECT_EQ(report.triangulated_lines, 0);
  }
  EXPECT_EQ(map.num<MapPoint>(), 0U);
  EXPECT_EQ(map.num<MapLine>(), 0U);
}

TEST_F(LocalMapperDepthlessTest, SegmentsAreTriangulatedOnlyWherePointsAreScarce) {
  for (const int points : {99, 100}) {
    SCOPED_TRACE(points);
    map = Map();
    point_ids.assign(scene.points.size(), kNoId);
    line_ids.assign(scene.lines.size(), kNoId);
    LocalMapper mapper(model, {});
    int triangulated = 0;
    for (const double x : {0.0, 0.25, 0.5}) {
      const SyntheticView view = LookWithoutDepthOfLines(x);
      TrackedFrame tracked = Tracked(view, At(x));
      tracked.num_points = points;
      triangulated += Insert(mapper, view, tracked).triangulated_lines;
    }
    EXPECT_EQ(triangulated > 10, points < 100);
    EXPECT_EQ(map.num<MapLine>() > 0, points < 100);
  }
}

}  // namespace
}  // namespace highwall::local_mapper_depthless_test
