#include <vector>

#include <gtest/gtest.h>

#include <highwall/frontend/map/measurement_model.h>

#include "pose/landmark_motion.h"
#include "support/synthetic_scene.h"

namespace highwall::landmark_motion_test {
namespace {

using testing::IdealSensor;
using testing::PositionError;
using testing::RandomDescriptor;
using testing::Scene;
using testing::UniformInBox;

PerKind<PoseObservations> Of(const std::vector<PosePoint>& points) {
  PerKind<PoseObservations> seen;
  seen.points = points;
  return seen;
}

// A wall far away and, in front of it, a panel with marks, which has moved since it was mapped.
class LandmarkMotion : public ::testing::Test {
 protected:
  // moved: number of the panel's `marks` that have moved by `shift` [m].
  void Look(const Eigen::Vector3d& shift, int marks = 20, int moved = 20, unsigned seed = 1) {
    std::mt19937 rng(seed);
    wall = See(rng, {-2.5, -1.5, 3.4}, {2.5, 1.5, 3.6}, 60, 0, shift);
    panel = See(rng, {-0.3, -0.4, 1.0}, {0.1, 0.4, 1.05}, marks, moved, shift);
  }
  bool Moved(const LandmarkMotionOptions& options = {}) const {
    return HaveMoved(Pose(), model.projection(), panel, lines, Of(wall), options);
  }

  const MeasurementModel model{IdealSensor(), {.point_sigma = 1.0}};  // that of the noise
  std::vector<PosePoint> wall, panel;
  int lines = 0;  // on the panel

 private:
  // Returns points in a box where they were mapped, with their observations by the camera at the
  // origin.
  std::vector<PosePoint> See(std::mt19937& rng, const Eigen::Vector3d& low,
                             const Eigen::Vector3d& high, int count, int moved,
                             const Eigen::Vector3d& shift) const {
    std::vector<PosePoint> points;
    for (int i = 0; i < count; ++i) {
      const Eigen::Vector3d p_W = UniformInBox(rng, low, high);
      const Eigen::Vector3d now = i < moved ? Eigen::Vector3d(p_W + shift) : p_W;
      const PointFeature feature =
          testing::SeePoint({now, RandomDescriptor(rng), 1.0}, Pose(), IdealSensor(),
                            {.px = 1.0, .depth = true}, rng);
      points.push_back({p_W, model.Rows(feature), MeasurementModel::Dimension(feature)});
    }
    return points;
  }
};

TEST_F(LandmarkMotion, MarksThatMovedContradictTheOthers) {
  for (const Eigen::Vector3d& shift : {Eigen::Vector3d(0.03, 0, 0), {0, 0.03, 0}, {0, 0, -0.03}}) {
    Look(shift);
    EXPECT_TRUE(Moved()) << shift.transpose();
  }
}

TEST_F(LandmarkMotion, LinesCountTowardsTheRestOfTheScene) {
  Look({0.03, 0, 0});
  lines = 15;  // 20 and 30 against some 55 of the 60 that fit
  EXPECT_TRUE(Moved());
  lines = 25;
  EXPECT_FALSE(Moved()) << "it may be the wall that moves";
}

TEST_F(LandmarkMotion, ThePoseOfAllTogetherWouldFollowThem) {
  // 60 marks nearby outweigh 60 points far away.
  Look({0.02, 0, 0}, 60, 60);
  std::vector<PosePoint> all = wall;
  all.insert(all.end(), panel.begin(), panel.end());
  const auto together = SolvePose(Pose(), model.projection(), Of(all));
  ASSERT_TRUE(together);
  EXPECT_GT(PositionError(together->T_WC, Pose()), 0.01);
  EXPECT_TRUE(Moved({.outnumber = 0.5}));
}

TEST_F(LandmarkMotion, OfTwoBodiesTheOneThatIsMoreOfTheSceneStands) {
  Look({0.1, 0, 0}, 70, 70);
  EXPECT_FALSE(Moved());
  EXPECT_TRUE(Moved({.outnumber = 0.5}));
}

TEST_F(LandmarkMotion, MarksThatStandDoNot) {
  for (unsigned seed = 1; seed <= 50; ++seed) {
    Look({0, 0, 0}, 20, 0, seed);
    EXPECT_FALSE(Moved()) << seed;
  }
}

TEST_F(LandmarkMotion, AFewMarksAreNoEvidence) {
  Look({0.1, 0, 0}, 7, 7);
  EXPECT_FALSE(Moved());
  EXPECT_TRUE(Moved({.min_points = 7}));
}

TEST_F(LandmarkMotion, MostOfTheMarksMustContradict) {
  Look({0.1, 0, 0}, 20, 10);
  EXPECT_FALSE(Moved());
  EXPECT_TRUE(Moved({.min_share = 0.4}));
}

TEST_F(LandmarkMotion, AnUnobservableDirectionOfTheOthersContradictsNothing) {
  // A small spot of the wall hardly constrains a rotation combined with a translation, which moves
  // a nearer panel.
  Look({0.03, 0, 0});
  EXPECT_TRUE(Moved());
  for (std::size_t i = 0; i < wall.size(); ++i) {
    std::mt19937 rng(static_cast<unsigned>(i));
    const Eigen::Vector3d p_W = UniformInBox(rng, {0.0, 0.0, 3.4}, {0.2, 0.2, 3.6});
    const PointFeature feature =
        testing::SeePoint({p_W, RandomDescriptor(rng), 1.0}, Pose(), IdealSensor(), {}, rng);
    wall[i] = {p_W, model.Rows(feature), MeasurementModel::Dimension(feature)};
  }
  EXPECT_FALSE(Moved());
  wall.resize(19);  // no pose at all
  EXPECT_FALSE(Moved());
}

}  // namespace
}  // namespace highwall::landmark_motion_test
