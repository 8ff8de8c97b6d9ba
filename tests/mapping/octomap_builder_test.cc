#include <highwall/mapping/octomap_builder.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <octomap/OcTree.h>

#include <highwall/core/error.h>
#include <highwall/core/so3.h>

#include "support/stock_octree.h"

namespace highwall::octomap_builder_test {
namespace {

using Points = std::vector<Eigen::Vector3f>;

void InsertStock(const Points& points_W, const Eigen::Vector3f& origin_W, double max_range,
                 octomap::OcTree& tree) {
  octomap::Pointcloud cloud;
  for (const Eigen::Vector3f& p : points_W) cloud.push_back(p.x(), p.y(), p.z());
  tree.insertPointCloud(cloud, {origin_W.x(), origin_W.y(), origin_W.z()},
                        std::isfinite(max_range) ? max_range : -1.0, false, true);
}

// Expects the same leaves (place, size and bit-identical log-odds) and the same inner nodes.
void ExpectEqual(const OctomapBuilder& map, octomap::OcTree& stock) {
  stock.updateInnerOccupancy();
  stock.prune();
  auto leaf = stock.begin_leafs();
  std::size_t differing = 0, count = 0;
  map.ForEachLeaf([&](const OctreeLeaf& ours) {
    ++count;
    if (leaf == stock.end_leafs()) return;
    const Eigen::Vector3d center(leaf.getX(), leaf.getY(), leaf.getZ());
    differing += ours.center_W != center || ours.size != leaf.getSize() ||
                 ours.log_odds != leaf->getLogOdds() ||
                 ours.occupied != stock.isNodeOccupied(*leaf);
    ++leaf;
  });
  EXPECT_EQ(differing, 0u);
  EXPECT_EQ(count, stock.getNumLeafNodes());
  EXPECT_EQ(map.NodeCount(), stock.calcNumNodes());
}

// A scan of a room of random size seen from inside, with clutter, in front of a random pose.
Points RandomScan(std::mt19937& rng, const Pose& T_WC) {
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  const Eigen::Vector3d wall(2.0 + u(rng), 2.0 + u(rng), 1.5 + u(rng));
  Points points_W;
  for (int i = 0; i < 1500; ++i) {
    const Eigen::Vector3d ray = T_WC.R() * Eigen::Vector3d(0.7 * u(rng), 0.6 * u(rng), 1.0);
    double t = (wall.array() / ray.array().abs()).minCoeff();
    if (i % 7 == 0) t *= 0.5 + 0.4 * u(rng);
    points_W.push_back((T_WC.p() + t * ray).cast<float>());
  }
  return points_W;
}

class EqualsStockOctomap : public ::testing::TestWithParam<OctomapBuilderOptions> {};

TEST_P(EqualsStockOctomap, LeafForLeafAfterEveryScan) {
  const OctomapBuilderOptions options = GetParam();
  OctomapBuilder map(options);
  octomap::OcTree stock = StockTree(options);
  std::mt19937 rng(7);
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  for (int scan = 0; scan < 12; ++scan) {
    const Pose T_WC(so3::Exp(Eigen::Vector3d(u(rng), u(rng), 3.0 * u(rng))),
                    0.4 * Eigen::Vector3d(u(rng), u(rng), u(rng)));
    const Points points_W = RandomScan(rng, T_WC);
    const Eigen::Vector3f origin_W = T_WC.p().cast<float>();
    map.InsertWorld(points_W, origin_W);
    InsertStock(points_W, origin_W, options.max_range, stock);
    SCOPED_TRACE("scan " + std::to_string(scan));
    ExpectEqual(map, stock);
  }
}

INSTANTIATE_TEST_SUITE_P(
    OctomapBuilder, EqualsStockOctomap,
    ::testing::Values(OctomapBuilderOptions{.resolution = 0.1,
                                            .max_range = std::numeric_limits<double>::infinity()},
                      OctomapBuilderOptions{.resolution = 0.1, .max_range = 1.7},
                      OctomapBuilderOptions{.resolution = 0.05, .max_range = 3.0},
                      OctomapBuilderOptions{.resolution = 0.083, .hit = 0.9, .miss = 0.3},
                      OctomapBuilderOptions{.resolution = 0.2,
                                            .clamp_min = 0.3,
                                            .clamp_max = 0.7,
                                            .occupancy_threshold = 0.65},
                      OctomapBuilderOptions{.resolution = 0.05, .threads = 3}));

TEST(OctomapBuilder, ThreadsMakeTheMapOfOneBitForBit) {
  // Far hits update the tree a second time, and a static view saturates the voxels and merges them.
  const OctomapBuilderOptions options{.resolution = 0.05, .max_range = 3.0, .far_range = 2.0};
  OctomapBuilder one(options);
  std::vector<OctomapBuilder> others;
  for (const int threads : {2, 4}) {
    OctomapBuilderOptions parallel = options;
    parallel.threads = threads;
    others.emplace_back(parallel);
  }
  std::mt19937 rng(17);
  for (int scan = 0; scan < 20; ++scan) {
    const double turn = 0.02 * std::max(0, scan - 10);
    const Pose T_WC = Pose::FromTangent({0.1, turn, 0.05}, {0.1, turn, 0.0});
    const Points points_W = RandomScan(rng, T_WC);
    one.InsertWorld(points_W, T_WC.p().cast<float>());
    std::vector<OctreeLeaf> expected;
    one.ForEachLeaf([&](const OctreeLeaf& leaf) { expected.push_back(leaf); });
    for (OctomapBuilder& other : others) {
      other.InsertWorld(points_W, T_WC.p().cast<float>());
      std::size_t i = 0;
      other.ForEachLeaf([&](const OctreeLeaf& leaf) {
        ASSERT_LT(i, expected.size());
        ASSERT_EQ(leaf.center_W, expected[i].center_W);
        ASSERT_EQ(leaf.size, expected[i].size);
        ASSERT_EQ(leaf.log_odds, expected[i++].log_odds);
      });
      ASSERT_EQ(i, expected.size());
      ASSERT_EQ(other.NodeCount(), one.NodeCount());
    }
  }
}

TEST(OctomapBuilder, EqualsStockOctomapWhereTheViewStandsStill) {
  // Space saturates, and regions of equal voxels split and merge again.
  const OctomapBuilderOptions options{.resolution = 0.1, .max_range = 10.0};
  OctomapBuilder map(options);
  octomap::OcTree stock = StockTree(options);
  std::mt19937 rng(11);
  const Pose T_WC(so3::Exp(Eigen::Vector3d(0.3, 0.1, -0.2)), {0.05, 0.05, 0.05});
  for (int scan = 0; scan < 12; ++scan) {
    const Points points_W = RandomScan(rng, T_WC);
    map.InsertWorld(points_W, T_WC.p().cast<float>());
    InsertStock(points_W, T_WC.p().cast<float>(), options.max_range, stock);
  }
  ExpectEqual(map, stock);
}

TEST(OctomapBuilder, EqualsStockOctomapForRaysAlongAxesAndThroughEdges) {
  // With multiples of the resolution every ray meets edges and corners of voxels.
  const OctomapBuilderOptions options{.resolution = 0.125, .max_range = 10.0};
  OctomapBuilder map(options);
  octomap::OcTree stock = StockTree(options);
  Points points_W;
  for (int x = -4; x <= 4; ++x) {
    for (int y = -4; y <= 4; ++y) {
      for (int z = -4; z <= 4; ++z) {
        points_W.emplace_back(0.25f * static_cast<float>(x), 0.25f * static_cast<float>(y),
                              0.25f * static_cast<float>(z));
      }
    }
  }
  for (const Eigen::Vector3f& origin_W : {Eigen::Vector3f(0, 0, 0), Eigen::Vector3f(0.0625f, 0, 0),
                                          Eigen::Vector3f(-2, 0.5f, 0.25f)}) {
    map.InsertWorld(points_W, origin_W);
    InsertStock(points_W, origin_W, options.max_range, stock);
    ExpectEqual(map, stock);
  }
}

TEST(OctomapBuilder, DepthPointsAndWorldPointsMakeTheSameMap) {
  const PinholeCamera camera{
      .width = 32, .height = 24, .fx = 26, .fy = 26, .cx = 15.5, .cy = 11.5, .k1 = 0.1, .p1 = 0.01};
  cv::Mat depth(camera.height, camera.width, CV_32FC1);
  const DepthUnprojector unprojector(camera);
  Points points_C;
  for (int v = 0; v < depth.rows; ++v) {
    for (int u = 0; u < depth.cols; ++u) {
      depth.at<float>(v, u) = 1.0f + 0.03f * static_cast<float>((u * 7 + v * 5) % 31);
      points_C.push_back(unprojector.Unproject(u, v, depth.at<float>(v, u)));
    }
  }
  const Pose T_WC(so3::Exp(Eigen::Vector3d(0.2, -0.5, 0.9)), {1.0, -2.0, 0.5});
  OctomapBuilder from_depth, from_points, from_camera;
  from_depth.Insert(depth, unprojector, T_WC);
  from_camera.Insert(depth, camera, T_WC);
  from_points.Insert(points_C, T_WC);
  ASSERT_GT(from_depth.LeafCount().occupied, 50u);
  for (const OctomapBuilder* other : {&from_camera, &from_points}) {
    EXPECT_EQ(from_depth.LeafCount().occupied, other->LeafCount().occupied);
    EXPECT_EQ(from_depth.LeafCount().free, other->LeafCount().free);
  }
  EXPECT_EQ(from_depth.IsOccupied(T_WC * points_C[100].cast<double>()), true);
  EXPECT_EQ(from_depth.IsOccupied(T_WC * (0.5 * points_C[100]).cast<double>()), false);
}

const Eigen::Vector3d kWall(2.025, 0.025, 0.025);
const Eigen::Vector3d kBetween(1.025, 0.025, 0.025);
const Points kWallPoint = {kWall.cast<float>()};
const Points kObjectPoint = {kBetween.cast<float>()};
const Eigen::Vector3f kSensor(0.025f, 0.025f, 0.025f);

TEST(OctomapBuilder, OneScanAddsHitAndMissOnce) {
  OctomapBuilder map;
  EXPECT_EQ(map.Occupancy(kWall), std::nullopt);
  EXPECT_TRUE(map.Bounds().isEmpty());
  map.InsertWorld(kWallPoint, kSensor);
  // Log-odds are floats.
  EXPECT_NEAR(map.Occupancy(kWall).value(), 0.7, 1e-6);
  EXPECT_NEAR(map.Occupancy(kBetween).value(), 0.4, 1e-6);
  EXPECT_EQ(map.Occupancy({1.025, 0.125, 0.025}), std::nullopt);
  EXPECT_EQ(map.LeafCount().occupied, 1u);
  // One row of 41 voxels of 0.05 m.
  EXPECT_TRUE(map.Bounds().min().isApprox(Eigen::Vector3d::Zero(), 1e-9) ||
              map.Bounds().min().norm() < 1e-9);
  EXPECT_LT((map.Bounds().max() - Eigen::Vector3d(2.05, 0.05, 0.05)).norm(), 1e-9);
  EXPECT_GT(map.MemoryBytes(), map.NodeCount() * sizeof(float));
}

TEST(OctomapBuilder, ClearsSpaceWhenAnObjectLeaves) {
  OctomapBuilder map;
  for (int i = 0; i < 3; ++i) map.InsertWorld(kObjectPoint, kSensor);
  ASSERT_EQ(map.IsOccupied(kBetween), true);
  // 3 hits of logit(0.7) = 0.847 against misses of logit(0.4) = -0.405: seven misses clear the
  // voxel.
  for (int i = 0; i < 6; ++i) map.InsertWorld(kWallPoint, kSensor);
  EXPECT_EQ(map.IsOccupied(kBetween), true);
  map.InsertWorld(kWallPoint, kSensor);
  EXPECT_EQ(map.IsOccupied(kBetween), false);
  EXPECT_EQ(map.IsOccupied(kWall), true);
}

TEST(OctomapBuilder, ClampsBothWays) {
  OctomapBuilder map;
  for (int i = 0; i < 100; ++i) map.InsertWorld(kWallPoint, kSensor);
  EXPECT_NEAR(map.Occupancy(kWall).value(), 0.97, 1e-6);
  EXPECT_NEAR(map.Occupancy(kBetween).value(), 0.12, 1e-6);
}

TEST(OctomapBuilder, HitsWinOverMissesOfTheSameScan) {
  OctomapBuilder map;
  map.InsertWorld(Points{kObjectPoint[0], kWallPoint[0]}, kSensor);
  EXPECT_NEAR(map.Occupancy(kBetween).value(), 0.7, 1e-6);
}

TEST(OctomapBuilder, RaysBeyondTheRangeClearUpToItAndMarkNothing) {
  OctomapBuilder map({.max_range = 1.5});
  map.InsertWorld(kWallPoint, kSensor);
  EXPECT_EQ(map.LeafCount().occupied, 0u);
  EXPECT_EQ(map.IsOccupied(kBetween), false);
  EXPECT_EQ(map.Occupancy(kWall), std::nullopt);
}

TEST(OctomapBuilder, LearnsNothingFromHolesAndEmptyImages) {
  const PinholeCamera camera{.width = 4, .height = 3, .fx = 4, .fy = 4, .cx = 1.5, .cy = 1};
  cv::Mat depth = cv::Mat::zeros(3, 4, CV_32FC1);
  OctomapBuilder map({.min_depth = 0.0});
  map.Insert(depth, camera, Pose());
  map.Insert(cv::Mat(), camera, Pose());
  depth.setTo(std::numeric_limits<float>::quiet_NaN());
  map.Insert(depth, camera, Pose());
  depth.setTo(std::numeric_limits<float>::infinity());
  map.Insert(depth, camera, Pose());
  map.Insert(Points{}, Pose());
  map.InsertWorld(Points{{std::numeric_limits<float>::quiet_NaN(), 0, 0}}, kSensor);
  EXPECT_EQ(map.NodeCount(), 0u);
}

TEST(OctomapBuilder, IgnoresPointsOutsideOfTheMap) {
  OctomapBuilder map({.max_range = 1e9});
  map.InsertWorld(Points{{1700, 0, 0}, {0, -1e30f, 0}}, kSensor);
  map.InsertWorld(kWallPoint, {0, 0, 5000});
  EXPECT_EQ(map.NodeCount(), 0u);
  EXPECT_EQ(map.Occupancy({1e30, 0, 0}), std::nullopt);
  EXPECT_EQ(map.Occupancy({std::nan(""), 0, 0}), std::nullopt);
}

TEST(OctomapBuilder, FarHitsCountLess) {
  OctomapBuilder map({.far_range = 1.5});
  map.InsertWorld(kWallPoint, kSensor);
  EXPECT_NEAR(map.Occupancy(kWall).value(), 0.6, 1e-6);
  EXPECT_NEAR(map.Occupancy(kBetween).value(), 0.4, 1e-6);
  map.Clear();
  map.InsertWorld(kObjectPoint, kSensor);
  EXPECT_NEAR(map.Occupancy(kBetween).value(), 0.7, 1e-6);
  // The last scan has left no state behind: a near hit still counts in full.
  map.InsertWorld(kObjectPoint, kSensor);
  EXPECT_NEAR(map.Occupancy(kBetween).value(), 0.49 / (0.49 + 0.09), 1e-6);
}

TEST(OctomapBuilder, FarHitsThatCountInFullChangeNothing) {
  OctomapBuilder near({.resolution = 0.1, .max_range = 10.0});
  OctomapBuilder far({.resolution = 0.1, .max_range = 10.0, .far_range = 1.5, .far_hit = 0.7});
  std::mt19937 rng(13);
  for (int scan = 0; scan < 5; ++scan) {
    const Pose T_WC = Pose::FromTangent({0.1 * scan, 0.0, 0.05}, {0.1, 0.2 * scan, 0.0});
    const Points points_W = RandomScan(rng, T_WC);
    near.InsertWorld(points_W, T_WC.p().cast<float>());
    far.InsertWorld(points_W, T_WC.p().cast<float>());
  }
  std::vector<float> expected;
  near.ForEachLeaf([&](const OctreeLeaf& leaf) { expected.push_back(leaf.log_odds); });
  std::size_t i = 0;
  far.ForEachLeaf([&](const OctreeLeaf& leaf) {
    ASSERT_LT(i, expected.size());
    ASSERT_EQ(leaf.log_odds, expected[i++]);
  });
  EXPECT_EQ(i, expected.size());
}

TEST(OctomapBuilder, ReportsWhereItChanged) {
  OctomapBuilder map;
  std::vector<Eigen::AlignedBox3d> boxes;
  map.SetChangeCallback([&](const Eigen::AlignedBox3d& box) { boxes.push_back(box); });
  map.InsertWorld(kWallPoint, kSensor);
  map.InsertWorld(Points{}, kSensor);
  ASSERT_EQ(boxes.size(), 1u) << "nothing changed the second time";
  EXPECT_TRUE(boxes[0].contains(map.Bounds()));
  // Bricks of 0.4 m along the ray from 0 to 2.05 m.
  EXPECT_TRUE(boxes[0].sizes().isApprox(Eigen::Vector3d(2.4, 0.4, 0.4), 1e-9));
  map.Clear();
  ASSERT_EQ(boxes.size(), 2u);
  map.SetChangeCallback({});
  map.InsertWorld(kWallPoint, kSensor);
  EXPECT_EQ(boxes.size(), 2u);
}

TEST(OctomapBuilder, ForgetsTheMapOnClear) {
  OctomapBuilder map;
  map.InsertWorld(kWallPoint, kSensor);
  map.Clear();
  EXPECT_EQ(map.NodeCount(), 0u);
  map.InsertWorld(kWallPoint, kSensor);
  EXPECT_NEAR(map.Occupancy(kWall).value(), 0.7, 1e-6);
}

TEST(OctomapBuilder, RefusesPosesThatAreNotFiniteAndForeignImages) {
  OctomapBuilder map;
  Pose pose;
  pose.data()[0] = std::numeric_limits<double>::quiet_NaN();
  const PinholeCamera camera{.width = 4, .height = 3, .fx = 4, .fy = 4, .cx = 1.5, .cy = 1};
  const cv::Mat depth(3, 4, CV_32FC1, cv::Scalar(1.0f));
  EXPECT_THROW(map.Insert(depth, camera, pose), InvalidArgument);
  EXPECT_THROW(map.Insert(kWallPoint, pose), InvalidArgument);
  EXPECT_THROW(map.InsertWorld(kWallPoint, Eigen::Vector3f::Constant(std::nanf(""))),
               InvalidArgument);
  EXPECT_THROW(map.Insert(cv::Mat(3, 4, CV_16UC1), camera, Pose()), InvalidArgument);
  EXPECT_THROW(map.Insert(cv::Mat(2, 4, CV_32FC1), camera, Pose()), InvalidArgument);
  EXPECT_EQ(map.NodeCount(), 0u);
}

TEST(OctomapBuilderOptions, RefusesValuesOutOfRange) {
  const auto refuses = [](const OctomapBuilderOptions& options) {
    EXPECT_THROW(OctomapBuilder{options}, InvalidArgument);
  };
  refuses({.resolution = 0.0});
  refuses({.resolution = -0.05});
  refuses({.resolution = std::nan("")});
  refuses({.min_depth = -1.0});
  refuses({.max_range = 0.0});
  refuses({.hit = 0.5});
  refuses({.miss = 0.5});
  refuses({.far_range = 0.0});
  refuses({.far_hit = 0.5});
  refuses({.clamp_min = 0.0});
  refuses({.clamp_max = 1.0});
  refuses({.occupancy_threshold = 1.0});
  refuses({.threads = 0});
}

}  // namespace
}  // namespace highwall::octomap_builder_test
