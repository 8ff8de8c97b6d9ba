#include <highwall/mapping/dense_cloud.h>

#include <limits>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include <highwall/core/error.h>
#include <highwall/core/so3.h>

namespace highwall::dense_cloud_test {
namespace {

using Points = std::vector<ColoredPoint>;
using Poses = std::vector<Pose>;

ColoredPoint Point(float x, float y, float z, std::uint8_t grey = 0) {
  return {.p = {x, y, z}, .rgb = {grey, grey, grey}};
}

Pose Shift(double x) {
  return Pose(Eigen::Quaterniond::Identity(), {x, 0, 0});
}

void ExpectEqual(const Points& a, const Points& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    ASSERT_EQ(a[i].p, b[i].p) << i;
    ASSERT_EQ(a[i].normal, b[i].normal) << i;
    ASSERT_EQ(a[i].rgb, b[i].rgb) << i;
  }
}

TEST(DenseCloud, MergesKeyframesInTheWorld) {
  DenseCloud cloud({.voxel_size = 0.5});
  cloud.SetKeyframe(1, Points{Point(0.25f, 0.25f, 1.25f, 100)});
  cloud.SetKeyframe(2, Points{Point(0.25f, 0.25f, 0.25f, 200)});
  EXPECT_TRUE(cloud.Merged().empty()) << "no keyframe has a pose yet";
  cloud.SetPose(1, Pose());
  cloud.SetPose(2, Pose(Eigen::Quaterniond::Identity(), {0, 0, 1}));
  EXPECT_TRUE(cloud.IsCurrent());
  const auto merged = cloud.Merged();
  ASSERT_EQ(merged.size(), 1u);
  // Coordinates are stored in steps of 1.25 m / 32767.
  EXPECT_LT((merged[0].p - Eigen::Vector3f(0.25f, 0.25f, 1.25f)).norm(), 4e-5f);
  EXPECT_EQ(merged[0].rgb[0], 150);
}

TEST(DenseCloud, PointsAndNormalsFollowTheirKeyframeWhenItMoves) {
  DenseCloud cloud;
  Points points = {Point(1, 2, 3)};
  points[0].normal = {0, 0, -1};
  cloud.SetKeyframe(7, points);
  cloud.SetPose(7, Pose());
  const Pose T_WC(so3::Exp(Eigen::Vector3d(0.1, -0.4, 1.2)), {5, -6, 7});
  cloud.SetPose(7, T_WC);
  EXPECT_FALSE(cloud.IsCurrent());
  EXPECT_TRUE(cloud.Rebuild());
  const ColoredPoint moved = cloud.Merged().at(0);
  // Half a quantization step of 3 m / 32767 along each axis.
  EXPECT_LT((moved.p.cast<double>() - T_WC * Eigen::Vector3d(1, 2, 3)).norm(), 1e-4);
  EXPECT_LT((moved.normal.cast<double>() - T_WC.R() * -Eigen::Vector3d::UnitZ()).norm(), 1e-6);
}

// Keyframes along a corridor, where neighbours overlap.
Points Scan(std::int64_t id) {
  std::mt19937 rng(static_cast<unsigned>(id) + 1u);
  std::uniform_real_distribution<float> u(-1.0f, 1.0f);
  Points points;
  for (int i = 0; i < 500; ++i) {
    points.push_back(Point(u(rng), u(rng), 2.0f, static_cast<std::uint8_t>(i % 256)));
    points.back().normal = {0, 0, -1};
  }
  return points;
}

// A large voxel contains many common points, and all of them are stored.
DenseCloudOptions Coarse() {
  return {.voxel_size = 0.05, .max_observations = 256};
}

Points FromScratch(const Poses& poses) {
  DenseCloud cloud(Coarse());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const auto id = static_cast<std::int64_t>(i);
    cloud.SetKeyframe(id, Scan(id));
    cloud.SetPose(id, poses[i]);
  }
  return cloud.Merged();
}

TEST(DenseCloud, EqualsACloudFromScratchAfterKeyframesMoved) {
  for (const std::size_t moved : {2, 20}) {  // some blocks, then all blocks
    Poses poses;
    DenseCloud cloud(Coarse());
    for (std::int64_t id = 0; id < 20; ++id) {
      poses.push_back(Shift(0.7 * static_cast<double>(id)));
      cloud.SetKeyframe(id, Scan(id));
      cloud.SetPose(id, poses.back());
    }
    const Points before = cloud.Merged();
    ExpectEqual(before, FromScratch(poses));
    for (std::size_t i = 0; i < moved; ++i) {
      poses[i] = Shift(0.7 * static_cast<double>(i) + 0.13);
      cloud.SetPose(static_cast<std::int64_t>(i), poses[i]);
    }
    while (!cloud.Rebuild(std::chrono::duration<double>(0.0))) ExpectEqual(cloud.Merged(), before);
    ExpectEqual(cloud.Merged(), FromScratch(poses));
  }
}

TEST(DenseCloud, ResultDependsOnTheContentAlone) {
  const Points a = Scan(1), b = Scan(2);
  DenseCloud forward(Coarse()), backward(Coarse());
  forward.SetKeyframe(1, a);
  forward.SetKeyframe(2, b);
  forward.SetPose(1, Shift(0));
  forward.SetPose(2, Shift(0.3));
  backward.SetKeyframe(2, b);
  backward.SetPose(2, Shift(0.3));
  backward.SetKeyframe(1, b);
  backward.SetPose(1, Shift(0));
  backward.SetKeyframe(1, a);
  EXPECT_FALSE(backward.IsCurrent());
  EXPECT_TRUE(backward.Rebuild());
  ExpectEqual(forward.Merged(), backward.Merged());
}

TEST(DenseCloud, KeyframesThatMoveOverFromAnotherEqualACloudFromScratch) {
  for (const std::int64_t first : {0, 12, 17}) {  // older ones, newer ones, and only a few
    Poses poses;
    DenseCloud cloud(Coarse()), other(Coarse());
    for (std::int64_t id = 0; id < 20; ++id) {
      poses.push_back(Shift(0.7 * static_cast<double>(id)));
      const bool moves = first == 0 ? id < 8 : id >= first;
      DenseCloud& holder = moves ? other : cloud;
      holder.SetKeyframe(id, Scan(id));
      holder.SetPose(
          id, moves ? Pose(so3::Exp(Eigen::Vector3d(0.3, 0.7, -0.4)), {0, 3, 1}) : poses.back());
    }
    const Points before = cloud.Merged();
    for (std::int64_t id = 0; id < 20; ++id) {
      if (!other.Contains(id)) continue;
      other.MoveKeyframe(id, poses[static_cast<std::size_t>(id)], cloud);
      EXPECT_TRUE(cloud.Contains(id));
      EXPECT_FALSE(other.Contains(id));
    }
    EXPECT_FALSE(cloud.IsCurrent());
    EXPECT_FALSE(other.IsCurrent());
    int calls = 1;
    for (; !cloud.Rebuild(std::chrono::duration<double>(0.0)); ++calls) {
      ExpectEqual(cloud.Merged(), before);
    }
    EXPECT_GE(calls, 3);
    ExpectEqual(cloud.Merged(), FromScratch(poses));
    EXPECT_TRUE(other.Rebuild());
    EXPECT_TRUE(other.Merged().empty());
    EXPECT_EQ(other.KeyframeCount(), 0u);
  }
}

TEST(DenseCloud, AKeyframeThatMovesOverTakesThePlaceOfAnother) {
  DenseCloud cloud, other;
  for (DenseCloud* const holder : {&cloud, &other}) {
    holder->SetKeyframe(1, Points{Point(holder == &cloud ? 1.0f : 2.0f, 0, 0)});
    holder->SetPose(1, Pose());
  }
  other.MoveKeyframe(1, Shift(3), cloud);
  EXPECT_TRUE(cloud.Rebuild());
  const Points merged = cloud.Merged();
  ASSERT_EQ(merged.size(), 1u);
  EXPECT_EQ(merged[0].p.x(), 5.0f);
}

TEST(DenseCloud, MemoryIsBoundedByTheAreaSeen) {
  DenseCloud cloud({.voxel_size = 0.05, .max_observations = 3});
  std::size_t bytes = 0;
  for (std::int64_t id = 0; id < 60; ++id) {
    cloud.SetKeyframe(id, Scan(id));
    cloud.SetPose(id, Pose());
    if (id == 30) bytes = cloud.MemoryBytes();
  }
  EXPECT_EQ(cloud.KeyframeCount(), 60u);
  // At most 41 x 41 x 1 voxels with three observations each remain of 60 x 500 points.
  EXPECT_LE(cloud.PointCount(), 3u * 41u * 41u);
  EXPECT_LT(static_cast<double>(cloud.MemoryBytes()), 1.05 * static_cast<double>(bytes));
}

TEST(DenseCloud, ForgetsRemovedKeyframes) {
  DenseCloud cloud;
  cloud.SetKeyframe(1, Points{Point(1, 1, 1)});
  cloud.SetPose(1, Pose());
  cloud.RemoveKeyframe(1);
  cloud.RemoveKeyframe(1);
  EXPECT_FALSE(cloud.Contains(1));
  EXPECT_EQ(cloud.PointCount(), 0u);
  EXPECT_TRUE(cloud.Rebuild());
  EXPECT_TRUE(cloud.Merged().empty());
}

TEST(DenseCloud, RefusesUnknownKeyframesAndPosesThatAreNotFinite) {
  DenseCloud cloud;
  EXPECT_THROW(cloud.SetPose(1, Pose()), InvalidArgument);
  cloud.SetKeyframe(1, {});
  Pose pose;
  pose.data()[3] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(cloud.SetPose(1, pose), InvalidArgument);
  DenseCloud other;
  EXPECT_THROW(cloud.MoveKeyframe(1, pose, other), InvalidArgument);
  EXPECT_THROW(cloud.MoveKeyframe(2, Pose(), other), InvalidArgument);
  EXPECT_TRUE(cloud.Contains(1));
  EXPECT_THROW(DenseCloud({.voxel_size = 0.0}), InvalidArgument);
  EXPECT_THROW(DenseCloud({.max_observations = 0}), InvalidArgument);
}

}  // namespace
}  // namespace highwall::dense_cloud_test
