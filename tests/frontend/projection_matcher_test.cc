#include <gtest/gtest.h>

#include "map/projection_matcher.h"
#include "support/synthetic_scene.h"

namespace highwall::projection_matcher_test {
namespace {

// Returns a descriptor with `count` of the 256 bits set.
BinaryDescriptor256 FirstBits(int count) {
  BinaryDescriptor256 descriptor{};
  for (int i = 0; i < count; ++i) {
    descriptor[static_cast<std::size_t>(i / 8)] |= static_cast<std::uint8_t>(1 << (i % 8));
  }
  return descriptor;
}

struct Corner {
  Eigen::Vector2d uv;
  int octave;
  int bits;
  float angle = 0.0F;
};

FrameFeatures MakeFeatures(const std::vector<Corner>& corners) {
  FrameFeatures features;
  for (const Corner& c : corners) {
    features.points.push_back({.uv = c.uv, .depth = 0.0, .octave = c.octave, .angle = c.angle});
    testing::AppendDescriptor(features.point_descriptors, FirstBits(c.bits));
  }
  testing::IndexPoints(features, PinholeCamera{});
  return features;
}

ProjectedPoint Expect(const Eigen::Vector2d& uv, int bits, double radius = 10.0) {
  ProjectedPoint projection;
  projection.uv = uv;
  projection.radius = radius;
  projection.min_octave = 0;
  projection.max_octave = 7;
  projection.descriptor = FirstBits(bits);
  return projection;
}

std::vector<ProjectionMatch> Match(const std::vector<Corner>& corners,
                                   const std::vector<ProjectedPoint>& projections,
                                   std::vector<bool> taken = {},
                                   const ProjectionMatchOptions& options = {}) {
  taken.resize(corners.size());
  return MatchProjections(MakeFeatures(corners), projections, taken, options);
}

TEST(MatchProjections, TakesTheClosestDescriptorInsideTheWindow) {
  const auto matches =
      Match({{{100, 100}, 0, 40}, {{104, 103}, 0, 5}, {{111, 100}, 0, 0}}, {Expect({100, 100}, 0)});
  ASSERT_EQ(matches.size(), 1u);
  EXPECT_EQ(matches[0].feature, 1) << "the third is a twin but 11 px away";
  EXPECT_EQ(matches[0].projection, 0);
  EXPECT_EQ(matches[0].hamming, 5);
}

TEST(MatchProjections, LooksAtTheExpectedLevelsAlone) {
  ProjectedPoint projection = Expect({100, 100}, 0);
  projection.min_octave = 2;
  projection.max_octave = 3;
  const auto matches =
      Match({{{100, 100}, 1, 0}, {{101, 100}, 2, 30}, {{102, 100}, 3, 20}, {{103, 100}, 4, 0}},
            {projection});
  ASSERT_EQ(matches.size(), 1u);
  EXPECT_EQ(matches[0].feature, 2);
}

TEST(MatchProjections, LeavesTakenFeaturesAlone) {
  const std::vector<Corner> corners{{{100, 100}, 0, 0}, {{101, 100}, 0, 30}};
  const auto matches = Match(corners, {Expect({100, 100}, 0)}, {true, false});
  ASSERT_EQ(matches.size(), 1u);
  EXPECT_EQ(matches[0].feature, 1);
  EXPECT_TRUE(Match(corners, {Expect({100, 100}, 0)}, {true, true}).empty());
}

TEST(MatchProjections, RefusesDistantDescriptors) {
  EXPECT_EQ(Match({{{100, 100}, 0, 50}}, {Expect({100, 100}, 0)}, {}, {.max_hamming = 50}).size(),
            1u);
  EXPECT_TRUE(
      Match({{{100, 100}, 0, 51}}, {Expect({100, 100}, 0)}, {}, {.max_hamming = 50}).empty());
}

TEST(MatchProjections, RivalOnTheSameLevelMakesItAmbiguous) {
  const ProjectionMatchOptions options{.max_hamming = 100, .ratio = 0.8};
  EXPECT_TRUE(
      Match({{{100, 100}, 1, 41}, {{102, 100}, 1, 50}}, {Expect({101, 100}, 0)}, {}, options)
          .empty());
  EXPECT_EQ(Match({{{100, 100}, 1, 39}, {{102, 100}, 1, 50}}, {Expect({101, 100}, 0)}, {}, options)
                .size(),
            1u);
  EXPECT_EQ(Match({{{100, 100}, 1, 41}, {{102, 100}, 2, 50}}, {Expect({101, 100}, 0)}, {}, options)
                .size(),
            1u)
      << "on the next level it is the same corner";
}

TEST(MatchProjections, RivalOnTheSameLevelCountsBehindOneOfAnother) {
  const ProjectionMatchOptions options{.max_hamming = 100, .ratio = 0.8};
  EXPECT_TRUE(Match({{{100, 100}, 1, 41}, {{101, 100}, 2, 42}, {{102, 100}, 1, 43}},
                    {Expect({101, 100}, 0)}, {}, options)
                  .empty());
}

TEST(MatchProjections, ComparesOrientationWhereItIsKnown) {
  ProjectedPoint projection = Expect({100, 100}, 0);
  projection.angle = 350.0F;
  const ProjectionMatchOptions options{.max_angle_diff = 30.0};
  EXPECT_EQ(Match({{{100, 100}, 0, 0, 15.0F}}, {projection}, {}, options).size(), 1u)
      << "25 degrees over the turn";
  EXPECT_TRUE(Match({{{100, 100}, 0, 0, 25.0F}}, {projection}, {}, options).empty());
  EXPECT_EQ(Match({{{100, 100}, 0, 0, -1.0F}}, {projection}, {}, options).size(), 1u)
      << "the feature has none";
  projection.angle.reset();
  EXPECT_EQ(Match({{{100, 100}, 0, 0, 180.0F}}, {projection}, {}, options).size(), 1u);
}

TEST(MatchProjections, GivesAContestedFeatureToTheCloserDescriptor) {
  const auto matches = Match({{{100, 100}, 0, 10}, {{300, 100}, 0, 0}},
                             {Expect({100, 101}, 0), Expect({100, 99}, 12), Expect({300, 100}, 0)});
  ASSERT_EQ(matches.size(), 2u);
  EXPECT_EQ(matches[0].feature, 0);
  EXPECT_EQ(matches[0].projection, 1);
  EXPECT_EQ(matches[0].hamming, 2);
  EXPECT_EQ(matches[1].feature, 1);
  EXPECT_EQ(matches[1].projection, 2);
}

TEST(MatchProjections, NothingFromNothing) {
  EXPECT_TRUE(Match({}, {Expect({100, 100}, 0)}).empty());
  EXPECT_TRUE(Match({{{100, 100}, 0, 0}}, {}).empty());
  EXPECT_TRUE(MatchProjections(FrameFeatures(), std::vector{Expect({1, 1}, 0)}, {}).empty());
}

class ProjectSegmentTest : public ::testing::Test {
 protected:
  void ExpectEnds(const std::optional<LineSegment>& segment, const Eigen::Vector2f& s,
                  const Eigen::Vector2f& e) const {
    ASSERT_TRUE(segment);
    // The precision of float pixels is 3e-5.
    EXPECT_LT((segment->s - s).norm(), 1e-4F) << segment->s.transpose();
    EXPECT_LT((segment->e - e).norm(), 1e-4F) << segment->e.transpose();
  }
  // Returns the point behind a pixel, which may be outside of the image.
  Eigen::Vector3d At(double u, double v, double z) const { return camera.Unproject({u, v}, z); }

  const PinholeCamera camera{};  // 640 x 480
};

TEST_F(ProjectSegmentTest, KeepsWhatIsInsideAndTheOrderOfItsEnds) {
  ExpectEnds(ProjectSegment({At(100, 50, 2), At(300, 400, 5)}, camera), {100, 50}, {300, 400});
  ExpectEnds(ProjectSegment({At(300, 400, 5), At(100, 50, 2)}, camera), {300, 400}, {100, 50});
}

TEST_F(ProjectSegmentTest, CutsAtTheBorder) {
  ExpectEnds(ProjectSegment({At(-100, 50, 2), At(100, 250, 2)}, camera), {0, 150}, {100, 250});
  ExpectEnds(ProjectSegment({At(600, 100, 2), At(700, 100, 3)}, camera), {600, 100}, {639, 100});
  ExpectEnds(ProjectSegment({At(200, -90, 2), At(200, 1000, 3)}, camera), {200, 0}, {200, 479});
  ExpectEnds(ProjectSegment({At(-10, 20, 2), At(20, -10, 2)}, camera), {0, 10}, {10, 0});
}

TEST_F(ProjectSegmentTest, IsEmptyOutsideOfTheImage) {
  EXPECT_FALSE(ProjectSegment({At(-100, 50, 2), At(-1, 250, 2)}, camera));
  EXPECT_FALSE(ProjectSegment({At(100, 480, 2), At(300, 480, 3)}, camera));
  EXPECT_FALSE(ProjectSegment({At(-20, 10, 2), At(10, -20, 2)}, camera)) << "past the corner";
  EXPECT_FALSE(ProjectSegment({At(640, 10, 2), At(640, 100, 2)}, camera));
}

TEST_F(ProjectSegmentTest, CutsAtTheNearPlane) {
  // The line goes from (0.1, 0, 1) back through the plane z = 0.25 at (0.1, 0, 0.25) and behind the
  // camera.
  const Segment3 segment({0.1, 0, 1.0}, {0.1, 0, -1.0});
  const double u_far = 319.5 + 52.5, u_near = 319.5 + 525.0 * 0.1 / 0.25;
  ExpectEnds(ProjectSegment(segment, camera, 0.25), {static_cast<float>(u_far), 239.5F},
             {static_cast<float>(u_near), 239.5F});
  ExpectEnds(ProjectSegment(Segment3(segment.q(), segment.p()), camera, 0.25),
             {static_cast<float>(u_near), 239.5F}, {static_cast<float>(u_far), 239.5F});
  EXPECT_FALSE(ProjectSegment({{0, 0, 0.2}, {0.1, 0, -1}}, camera, 0.25));
}

}  // namespace
}  // namespace highwall::projection_matcher_test
