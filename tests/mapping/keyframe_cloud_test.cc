#include <highwall/mapping/keyframe_cloud.h>

#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include <highwall/core/error.h>
#include <highwall/core/so3.h>

namespace highwall::keyframe_cloud_test {
namespace {

PinholeCamera SmallCamera() {
  return {.width = 4, .height = 3, .fx = 2.0, .fy = 4.0, .cx = 1.0, .cy = 1.0};
}

// Keeps every pixel as a separate point.
KeyframeCloudOptions KeepAll() {
  return {.edge_rejection = 0.0, .max_incidence = 90.0, .voxel_size = 1e-4};
}

cv::Mat Depth(float z) {
  return cv::Mat(3, 4, CV_32FC1, cv::Scalar(z));
}

ColoredPoint Point(float x, float y, float z, std::uint8_t grey = 0) {
  return {.p = {x, y, z}, .rgb = {grey, grey, grey}};
}

TEST(MakeKeyframeCloud, PutsAPlaneWhereTheHandComputationDoes) {
  const auto cloud = MakeKeyframeCloud(Depth(2.0f), {}, SmallCamera(), KeepAll());
  ASSERT_EQ(cloud.size(), 12u);
  // Row by row: x = (u - 1) 2 / 2, y = (v - 1) 2 / 4. All values are exact in binary.
  EXPECT_EQ(cloud[0].p, Eigen::Vector3f(-1.0f, -0.5f, 2.0f));
  EXPECT_EQ(cloud[3].p, Eigen::Vector3f(2.0f, -0.5f, 2.0f));
  EXPECT_EQ(cloud[5].p, Eigen::Vector3f(0.0f, 0.0f, 2.0f));
  EXPECT_EQ(cloud[11].p, Eigen::Vector3f(2.0f, 0.5f, 2.0f));
}

TEST(MakeKeyframeCloud, RemovesTheDistortionOfTheLens) {
  PinholeCamera camera;
  camera.k1 = 0.2624;
  camera.k2 = -0.9531;
  camera.p1 = -0.0054;
  camera.p2 = 0.0026;
  camera.k3 = 1.1633;
  cv::Mat depth = cv::Mat::zeros(camera.height, camera.width, CV_32FC1);
  depth.at<float>(40, 600) = 1.5f;
  const auto cloud = MakeKeyframeCloud(depth, {}, camera, KeepAll());
  ASSERT_EQ(cloud.size(), 1u);
  // A float has 24 bits: 1.5 m to 1e-7 m, some 1e-4 px.
  const Eigen::Vector2d uv = camera.Project(cloud[0].p.cast<double>());
  EXPECT_NEAR(uv.x(), 600.0, 2e-4);
  EXPECT_NEAR(uv.y(), 40.0, 2e-4);
}

TEST(MakeKeyframeCloud, TakesTheColourOfThePixelAsRgb) {
  cv::Mat bgr(3, 4, CV_8UC3, cv::Scalar(10, 20, 30));
  const auto cloud = MakeKeyframeCloud(Depth(1.0f), bgr, SmallCamera(), KeepAll());
  EXPECT_EQ(cloud.front().rgb, (std::array<std::uint8_t, 3>{30, 20, 10}));
  const auto white = MakeKeyframeCloud(Depth(1.0f), {}, SmallCamera(), KeepAll());
  EXPECT_EQ(white.front().rgb, (std::array<std::uint8_t, 3>{255, 255, 255}));
}

TEST(MakeKeyframeCloud, SkipsHolesNanAndDepthsOutOfRange) {
  cv::Mat depth = Depth(0.0f);
  depth.at<float>(0, 0) = std::numeric_limits<float>::quiet_NaN();
  depth.at<float>(0, 1) = std::numeric_limits<float>::infinity();
  depth.at<float>(0, 2) = 0.04f;
  depth.at<float>(0, 3) = 6.01f;
  depth.at<float>(1, 0) = -1.0f;
  EXPECT_TRUE(MakeKeyframeCloud(depth, {}, SmallCamera(), KeepAll()).empty());
  EXPECT_TRUE(MakeKeyframeCloud(cv::Mat(), {}, SmallCamera(), KeepAll()).empty());
}

TEST(MakeKeyframeCloud, StrideTakesEverySecondPixelOfEverySecondRow) {
  KeyframeCloudOptions options = KeepAll();
  options.stride = 2;
  EXPECT_EQ(MakeKeyframeCloud(Depth(1.0f), {}, SmallCamera(), options).size(), 4u);
}

TEST(MakeKeyframeCloud, DropsBothSidesOfADepthEdgeButNotTheBorderOfAHole) {
  cv::Mat depth = Depth(1.0f);
  depth.col(2).setTo(2.0f);
  depth.col(3).setTo(2.0f);
  depth.at<float>(0, 0) = 0.0f;
  KeyframeCloudOptions options = KeepAll();
  options.edge_rejection = 0.05;
  // Columns 1 and 2 are the edge, and the hole removes one pixel of columns 0 and 3.
  EXPECT_EQ(MakeKeyframeCloud(depth, {}, SmallCamera(), options).size(), 5u);
}

TEST(MakeKeyframeCloud, RefusesImagesOfAnotherTypeOrSize) {
  const PinholeCamera camera = SmallCamera();
  EXPECT_THROW(MakeKeyframeCloud(cv::Mat(3, 4, CV_16UC1), {}, camera), InvalidArgument);
  EXPECT_THROW(MakeKeyframeCloud(cv::Mat(4, 3, CV_32FC1), {}, camera), InvalidArgument);
  EXPECT_THROW(MakeKeyframeCloud(Depth(1), cv::Mat(3, 4, CV_8UC1), camera), InvalidArgument);
  EXPECT_THROW(MakeKeyframeCloud(Depth(1), cv::Mat(6, 8, CV_8UC3), camera), InvalidArgument);
}

constexpr double kDegree = 0.017453292519943295;

PinholeCamera WideCamera() {
  return {.width = 64, .height = 48, .fx = 60.0, .fy = 60.0, .cx = 31.5, .cy = 23.5};
}

// The plane n . p = d in front of a camera.
cv::Mat PlaneDepth(const PinholeCamera& camera, const Eigen::Vector3d& n, double d) {
  cv::Mat depth = cv::Mat::zeros(camera.height, camera.width, CV_32FC1);
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const double z = d / n.dot(camera.Unproject({u, v}, 1.0));
      if (z > 0.0 && z < 20.0) depth.at<float>(v, u) = static_cast<float>(z);
    }
  }
  return depth;
}

TEST(MakeKeyframeCloud, NormalsAreThoseOfThePlane) {
  const PinholeCamera camera = WideCamera();
  const Eigen::Vector3d n = Eigen::Vector3d(0.3, -0.2, -1.0).normalized();
  KeyframeCloudOptions options = KeepAll();
  options.normal_radius = 2;
  const auto cloud = MakeKeyframeCloud(PlaneDepth(camera, n, -1.5), {}, camera, options);
  ASSERT_EQ(cloud.size(), 64u * 48u);
  // Float depths of 1e-7 m over a base line of 0.1 m.
  for (const ColoredPoint& point : cloud) {
    ASSERT_LT((point.normal.cast<double>() - n).norm(), 2e-5);
  }
}

TEST(MakeKeyframeCloud, DropsSurfacesSeenAtAGrazingAngle) {
  const PinholeCamera camera = WideCamera();
  // A floor 1 m below: the ray (0, y, 1) meets it at an incidence of atan(1 / y).
  const cv::Mat depth = PlaneDepth(camera, {0, 1, 0}, 1.0);
  KeyframeCloudOptions options = KeepAll();
  options.max_depth = 20.0;
  options.normal_radius = 1;
  const auto all = MakeKeyframeCloud(depth, {}, camera, options);
  options.max_incidence = 75.0;
  const auto steep = MakeKeyframeCloud(depth, {}, camera, options);
  EXPECT_GT(all.size(), steep.size());
  ASSERT_FALSE(steep.empty());
  for (const ColoredPoint& point : steep) {
    const double incidence = std::acos(1.0 / point.p.norm()) / kDegree;
    // Near the horizon the normal is computed over a curved part of the depth profile.
    EXPECT_LT(incidence, 75.5);
  }
}

TEST(KeepAgreedDepth, DropsPointsThatNeighboursSeeThrough) {
  const PinholeCamera camera = WideCamera();
  const DepthUnprojector unprojector(camera);
  for (const double z : {2.0, 0.6}) {  // [m] depth of a wall
    const cv::Mat wall = PlaneDepth(camera, {0, 0, 1}, z);
    const auto ghost_z = static_cast<float>(0.5 * z);
    cv::Mat depth = wall.clone();
    depth(cv::Rect(30, 20, 4, 4)).setTo(ghost_z);  // visible in this view only
    std::vector<DepthView> neighbours;
    for (const double x : {-0.05 * z, 0.05 * z}) {
      neighbours.push_back({wall, Pose(Eigen::Quaterniond::Identity(), {x, 0, 0})});
    }
    const cv::Mat kept = KeepAgreedDepth({depth, Pose()}, neighbours, camera, unprojector);
    EXPECT_EQ(cv::countNonZero(kept), 64 * 48 - 16) << z;
    EXPECT_EQ(kept.at<float>(21, 31), 0.0f);
    EXPECT_EQ(depth.at<float>(21, 31), ghost_z) << "the image given stays as it is";
  }
}

TEST(KeepAgreedDepth, KeepsPointsThatNeighboursConfirmOrCannotSee) {
  const PinholeCamera camera = WideCamera();
  const DepthUnprojector unprojector(camera);
  const cv::Mat depth = PlaneDepth(camera, {0, 0, 1}, 2.0);
  const cv::Mat nearer = PlaneDepth(camera, {0, 0, 1}, 1.0);  // occludes the wall
  const std::vector<DepthView> one = {{nearer, Pose()}};
  EXPECT_EQ(cv::countNonZero(KeepAgreedDepth({depth, Pose()}, one, camera, unprojector)), 64 * 48);
  EXPECT_EQ(cv::countNonZero(KeepAgreedDepth({depth, Pose()}, one, camera, unprojector,
                                             {.needs_support = true})),
            0);
  // One neighbour agrees and one sees through the point: a draw.
  const std::vector<DepthView> two = {{depth, Pose()},
                                      {PlaneDepth(camera, {0, 0, 1}, 3.0), Pose()}};
  EXPECT_EQ(cv::countNonZero(KeepAgreedDepth({depth, Pose()}, two, camera, unprojector)), 64 * 48);
  EXPECT_THROW(KeepAgreedDepth({cv::Mat(3, 4, CV_32FC1), Pose()}, one, camera, unprojector),
               InvalidArgument);
  EXPECT_THROW(KeepAgreedDepth({depth, Pose()}, one, camera, unprojector, {.absolute = -1.0}),
               InvalidArgument);
}

TEST(RemoveOutliers, DropsPointsFarFromAllOthersAndKeepsTheOrder) {
  std::mt19937 rng(3);
  std::uniform_real_distribution<float> u(0.0f, 1.0f);
  std::vector<ColoredPoint> points;
  for (int i = 0; i < 1000; ++i) {
    points.push_back(Point(u(rng), u(rng), 0, static_cast<std::uint8_t>(i % 251)));
    if (i % 100 == 0) points.push_back(Point(u(rng), u(rng), 5.0f + 3.0f * u(rng), 255));
  }
  const auto kept = RemoveOutliers(points, 8, 2.0);
  // The ten distant points determine the spread of the distribution, and no inlier lies in its
  // tail.
  ASSERT_EQ(kept.size(), 1000u);
  for (std::size_t i = 0; i < kept.size(); ++i) ASSERT_EQ(kept[i].rgb[0], i % 251);
}

TEST(RemoveOutliers, MeasuresTheMeanDistanceToTheNearestPointsAndNotToMore) {
  const std::vector points{Point(0, 0, 0), Point(1, 0, 0), Point(3, 0, 0), Point(6, 0, 0)};
  // Distances to the nearest point: 1, 1, 2, 3, with a mean of 1.75 and a standard deviation of
  // 0.83.
  EXPECT_EQ(RemoveOutliers(points, 1, 0.0).size(), 2u);
  EXPECT_EQ(RemoveOutliers(points, 1, 0.5).size(), 3u);
  EXPECT_EQ(RemoveOutliers(points, 1, 1.6).size(), 4u);
  // Mean distances to the nearest two points: 2, 1.5, 2.5, 4, with a mean of 2.5 and 0.94.
  EXPECT_EQ(RemoveOutliers(points, 2, 0.0).size(), 3u);
  EXPECT_EQ(RemoveOutliers(points, 2, 1.65).size(), 4u);
}

TEST(RemoveOutliers, TakesAnyCloud) {
  EXPECT_TRUE(RemoveOutliers({}).empty());
  EXPECT_EQ(RemoveOutliers(std::vector{Point(1, 2, 3)}).size(), 1u);
  EXPECT_EQ(RemoveOutliers(std::vector(20, Point(1, 2, 3))).size(), 20u);
  EXPECT_EQ(RemoveOutliers(std::vector{Point(0, 0, NAN), Point(1, 2, 3)}).size(), 1u);
  EXPECT_THROW(RemoveOutliers({}, 0), InvalidArgument);
  EXPECT_THROW(RemoveOutliers({}, 1, -1.0), InvalidArgument);
}

TEST(KeyframeCloudOptions, RefusesValuesOutOfRange) {
  EXPECT_NO_THROW(KeyframeCloudOptions{}.Validate());
  EXPECT_THROW((KeyframeCloudOptions{.min_depth = 0.0}.Validate()), InvalidArgument);
  EXPECT_THROW((KeyframeCloudOptions{.max_depth = 0.05}.Validate()), InvalidArgument);
  EXPECT_THROW((KeyframeCloudOptions{.stride = 0}.Validate()), InvalidArgument);
  EXPECT_THROW((KeyframeCloudOptions{.edge_rejection = -0.1}.Validate()), InvalidArgument);
  EXPECT_THROW((KeyframeCloudOptions{.max_incidence = 0.0}.Validate()), InvalidArgument);
  EXPECT_THROW((KeyframeCloudOptions{.max_incidence = 91.0}.Validate()), InvalidArgument);
  EXPECT_THROW((KeyframeCloudOptions{.normal_radius = 0}.Validate()), InvalidArgument);
  EXPECT_THROW((KeyframeCloudOptions{.voxel_size = 0.0}.Validate()), InvalidArgument);
}

TEST(FilterVoxels, AveragesPositionAndColourPerVoxel) {
  const std::vector<ColoredPoint> points = {Point(0.125f, 0, 0, 10), Point(-0.125f, 0, 0, 99),
                                            Point(0.625f, 0.5f, 0.25f, 13)};
  const auto filtered = FilterVoxels(points, 1.0);
  ASSERT_EQ(filtered.size(), 2u);
  EXPECT_EQ(filtered[0].p, Eigen::Vector3f(0.375f, 0.25f, 0.125f));
  EXPECT_EQ(filtered[0].rgb[0], 12);  // 11.5, rounded
  EXPECT_EQ(filtered[1].p, points[1].p);
  EXPECT_EQ(filtered[1].rgb[0], 99);
}

TEST(FilterVoxels, AveragesNormals) {
  std::vector<ColoredPoint> points = {Point(0.1f, 0, 0), Point(0.2f, 0, 0), Point(5, 0, 0)};
  points[0].normal = {1, 0, 0};
  points[1].normal = {0, 1, 0};
  const auto filtered = FilterVoxels(points, 1.0);
  const float half = std::sqrt(0.5f);
  EXPECT_LT((filtered[0].normal - Eigen::Vector3f(half, half, 0)).norm(), 1e-6f);
  EXPECT_TRUE(filtered[1].normal.isZero()) << "unknown stays unknown";
}

TEST(FilterVoxels, KeepsOnePointPerVoxelOfALargeGrid) {
  std::vector<ColoredPoint> points;
  for (int repeat = 0; repeat < 2; ++repeat) {
    for (int i = 0; i < 20000; ++i) {
      points.push_back(Point(static_cast<float>(i % 200) - 99.5f, static_cast<float>(i / 200), 0.5f,
                             static_cast<std::uint8_t>(i % 251)));
    }
  }
  const auto filtered = FilterVoxels(points, 1.0);
  ASSERT_EQ(filtered.size(), 20000u);
  for (std::size_t i = 0; i < filtered.size(); ++i) {
    ASSERT_EQ(filtered[i].p, points[i].p);
    ASSERT_EQ(filtered[i].rgb, points[i].rgb);
  }
}

TEST(FilterVoxels, DropsNonFiniteAndTooFarPoints) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinity = std::numeric_limits<float>::infinity();
  const std::vector<ColoredPoint> points = {Point(nan, 0, 0), Point(0, infinity, 0),
                                            Point(0, 0, 1.1e6f), Point(1, 2, 3)};
  EXPECT_EQ(FilterVoxels(points, 1.0).size(), 1u);
  EXPECT_THROW(FilterVoxels(points, 0.0), InvalidArgument);
  EXPECT_THROW(FilterVoxels(points, nan), InvalidArgument);
}

}  // namespace
}  // namespace highwall::keyframe_cloud_test
