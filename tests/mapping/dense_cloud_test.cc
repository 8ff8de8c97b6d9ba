#include <highwall/mapping/dense_cloud.h>

#include <limits>

#include <gtest/gtest.h>

#include <highwall/core/error.h>
#include <highwall/core/so3.h>

namespace highwall {
namespace {

PinholeCamera SmallCamera() {
  return {.width = 4, .height = 3, .fx = 2.0, .fy = 4.0, .cx = 1.0, .cy = 1.0};
}

// Keeps every pixel as a point of its own.
DenseCloudOptions KeepAll() {
  return {.edge_rejection = 0.0, .voxel_size = 1e-4};
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
  // Row by row: x = (u - 1) 2 / 2, y = (v - 1) 2 / 4; all exact in binary.
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
  // A float carries 24 bits: 1.5 m to 1e-7 m, some 1e-4 px.
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
  depth.at<float>(0, 2) = 0.29f;
  depth.at<float>(0, 3) = 3.01f;
  depth.at<float>(1, 0) = -1.0f;
  EXPECT_TRUE(MakeKeyframeCloud(depth, {}, SmallCamera(), KeepAll()).empty());
  EXPECT_TRUE(MakeKeyframeCloud(cv::Mat(), {}, SmallCamera(), KeepAll()).empty());
}

TEST(MakeKeyframeCloud, StrideTakesEverySecondPixelOfEverySecondRow) {
  DenseCloudOptions options = KeepAll();
  options.stride = 2;
  EXPECT_EQ(MakeKeyframeCloud(Depth(1.0f), {}, SmallCamera(), options).size(), 4u);
}

TEST(MakeKeyframeCloud, DropsBothSidesOfADepthEdgeButNotTheBorderOfAHole) {
  cv::Mat depth = Depth(1.0f);
  depth.col(2).setTo(2.0f);
  depth.col(3).setTo(2.0f);
  depth.at<float>(0, 0) = 0.0f;
  DenseCloudOptions options = KeepAll();
  options.edge_rejection = 0.05;
  // Columns 1 and 2 are the edge; of columns 0 and 3 the hole is missing.
  EXPECT_EQ(MakeKeyframeCloud(depth, {}, SmallCamera(), options).size(), 5u);
}

TEST(MakeKeyframeCloud, RefusesImagesOfAnotherTypeOrSize) {
  const PinholeCamera camera = SmallCamera();
  EXPECT_THROW(MakeKeyframeCloud(cv::Mat(3, 4, CV_16UC1), {}, camera), InvalidArgument);
  EXPECT_THROW(MakeKeyframeCloud(cv::Mat(4, 3, CV_32FC1), {}, camera), InvalidArgument);
  EXPECT_THROW(MakeKeyframeCloud(Depth(1), cv::Mat(3, 4, CV_8UC1), camera), InvalidArgument);
  EXPECT_THROW(MakeKeyframeCloud(Depth(1), cv::Mat(6, 8, CV_8UC3), camera), InvalidArgument);
}

TEST(DenseCloudOptions, RefusesValuesOutOfRange) {
  EXPECT_NO_THROW(DenseCloudOptions{}.Validate());
  EXPECT_THROW((DenseCloudOptions{.min_depth = 0.0}.Validate()), InvalidArgument);
  EXPECT_THROW((DenseCloudOptions{.max_depth = 0.3}.Validate()), InvalidArgument);
  EXPECT_THROW((DenseCloudOptions{.stride = 0}.Validate()), InvalidArgument);
  EXPECT_THROW((DenseCloudOptions{.edge_rejection = -0.1}.Validate()), InvalidArgument);
  EXPECT_THROW((DenseCloudOptions{.voxel_size = 0.0}.Validate()), InvalidArgument);
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

TEST(FilterVoxels, DropsWhatIsNotFiniteOrTooFar) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinity = std::numeric_limits<float>::infinity();
  const std::vector<ColoredPoint> points = {Point(nan, 0, 0), Point(0, infinity, 0),
                                            Point(0, 0, 1.1e6f), Point(1, 2, 3)};
  EXPECT_EQ(FilterVoxels(points, 1.0).size(), 1u);
  EXPECT_THROW(FilterVoxels(points, 0.0), InvalidArgument);
  EXPECT_THROW(FilterVoxels(points, nan), InvalidArgument);
}

TEST(DenseCloud, MergesKeyframesInTheWorld) {
  DenseCloud cloud(0.5);
  cloud.SetKeyframe(1, {Point(0.25f, 0.25f, 1.25f, 100)});
  cloud.SetKeyframe(2, {Point(0.25f, 0.25f, 0.25f, 200)});
  EXPECT_TRUE(cloud.Merged().empty()) << "no keyframe has a pose yet";
  cloud.SetPose(1, Pose());
  cloud.SetPose(2, Pose(Eigen::Quaterniond::Identity(), {0, 0, 1}));
  const auto merged = cloud.Merged();
  ASSERT_EQ(merged.size(), 1u);
  EXPECT_EQ(merged[0].p, Eigen::Vector3f(0.25f, 0.25f, 1.25f));
  EXPECT_EQ(merged[0].rgb[0], 150);
}

TEST(DenseCloud, PointsFollowTheirKeyframeWhenItMoves) {
  DenseCloud cloud;
  cloud.SetKeyframe(7, {Point(1, 2, 3)});
  cloud.SetPose(7, Pose());
  const Pose T_WC(so3::Exp(Eigen::Vector3d(0.1, -0.4, 1.2)), {5, -6, 7});
  cloud.SetPose(7, T_WC);
  // Float arithmetic on coordinates below 16 m.
  EXPECT_NEAR((cloud.Merged().at(0).p.cast<double>() - T_WC * Eigen::Vector3d(1, 2, 3)).norm(), 0.0,
              3e-6);
}

TEST(DenseCloud, ResultDependsOnTheContentAlone) {
  const std::vector<ColoredPoint> a = {Point(0.1f, 0, 0, 1), Point(2, 0, 0, 2)};
  const std::vector<ColoredPoint> b = {Point(0.3f, 0, 0, 9), Point(3, 0, 0, 4)};
  DenseCloud forward(1.0), backward(1.0);
  forward.SetKeyframe(1, a);
  forward.SetKeyframe(2, b);
  backward.SetKeyframe(2, b);
  backward.SetKeyframe(1, b);
  backward.SetKeyframe(1, a);
  for (DenseCloud* cloud : {&forward, &backward}) {
    cloud->SetPose(1, Pose());
    cloud->SetPose(2, Pose());
  }
  const auto first = forward.Merged(), second = backward.Merged();
  ASSERT_EQ(first.size(), 3u);
  ASSERT_EQ(second.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(first[i].p, second[i].p);
    EXPECT_EQ(first[i].rgb, second[i].rgb);
  }
}

TEST(DenseCloud, ForgetsRemovedKeyframes) {
  DenseCloud cloud;
  cloud.SetKeyframe(1, {Point(1, 1, 1)});
  cloud.SetPose(1, Pose());
  cloud.RemoveKeyframe(1);
  cloud.RemoveKeyframe(1);
  EXPECT_FALSE(cloud.Contains(1));
  EXPECT_EQ(cloud.PointCount(), 0u);
  EXPECT_TRUE(cloud.Merged().empty());
}

TEST(DenseCloud, RefusesUnknownKeyframesAndPosesThatAreNotFinite) {
  DenseCloud cloud;
  EXPECT_THROW(cloud.SetPose(1, Pose()), InvalidArgument);
  cloud.SetKeyframe(1, {});
  Pose pose;
  pose.data()[3] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(cloud.SetPose(1, pose), InvalidArgument);
  EXPECT_THROW(DenseCloud(0.0), InvalidArgument);
}

}  // namespace
}  // namespace highwall
