#include "input/colour_to_depth.h"

#include <cstdint>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

namespace highwall::colour_to_depth_test {
namespace {

PinholeCamera Camera(int width, int height, double focal) {
  return {.width = width,
          .height = height,
          .fx = focal,
          .fy = focal,
          .cx = (width - 1) / 2.0,
          .cy = (height - 1) / 2.0};
}

// Every pixel has a value of its own.
cv::Mat Numbered(int width, int height) {
  cv::Mat image(height, width, CV_16UC1);
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      image.at<std::uint16_t>(v, u) = static_cast<std::uint16_t>(v * width + u + 1);
    }
  }
  return image;
}

TEST(FrameSize, IsTheLargestIntegerFractionOfColourWithin640By480) {
  const cv::Size lidar(256, 192);
  EXPECT_EQ(FrameSize({1920, 1440}, lidar), cv::Size(640, 480));
  EXPECT_EQ(FrameSize({1440, 1920}, {192, 256}), cv::Size(480, 640));
  EXPECT_EQ(FrameSize({1280, 960}, lidar), cv::Size(640, 480));
  EXPECT_EQ(FrameSize({960, 720}, lidar), cv::Size(480, 360));
  EXPECT_EQ(FrameSize({640, 480}, lidar), cv::Size(640, 480));
}

TEST(FrameSize, IsThatOfEqualImagesWhateverItIs) {
  EXPECT_EQ(FrameSize({1920, 1440}, {1920, 1440}), cv::Size(1920, 1440));
  EXPECT_EQ(FrameSize({256, 192}, {256, 192}), cv::Size(256, 192));
}

TEST(ResizedCamera, KeepsTheEdgesOfTheImageWhereTheyAre) {
  PinholeCamera camera = Camera(1920, 1440, 1352.0);
  camera.cx = 962.0;
  const PinholeCamera small = ResizedCamera(camera, {640, 480});
  EXPECT_EQ(small.width, 640);
  EXPECT_EQ(small.height, 480);
  EXPECT_DOUBLE_EQ(small.fx, 1352.0 / 3.0);
  // The left edge is at -0.5 in both: the same ray.
  EXPECT_NEAR((-0.5 - small.cx) / small.fx, (-0.5 - camera.cx) / camera.fx, 1e-12);
  EXPECT_NEAR((639.5 - small.cx) / small.fx, (1919.5 - camera.cx) / camera.fx, 1e-12);
}

TEST(ResampleColour, AveragesOverAreas) {
  cv::Mat colour(12, 18, CV_8UC3);
  cv::RNG(1).fill(colour, cv::RNG::UNIFORM, 0, 256);
  const PinholeCamera from = Camera(18, 12, 15.0);
  const cv::Mat reduced = ResampleColour(colour, from, ResizedCamera(from, {6, 4}));
  ASSERT_EQ(reduced.size(), cv::Size(6, 4));
  for (int v = 0; v < 4; ++v) {
    for (int u = 0; u < 6; ++u) {
      const cv::Scalar mean = cv::mean(colour(cv::Rect(3 * u, 3 * v, 3, 3)));
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(reduced.at<cv::Vec3b>(v, u)[c], mean[c], 0.51);
    }
  }
}

TEST(ResampleColour, IsTheImageItselfForTheSameCamera) {
  cv::Mat colour(12, 18, CV_8UC3);
  cv::RNG(1).fill(colour, cv::RNG::UNIFORM, 0, 256);
  const PinholeCamera camera = Camera(18, 12, 15.0);
  EXPECT_EQ(cv::norm(ResampleColour(colour, camera, camera), colour, cv::NORM_INF), 0.0);
}

TEST(ResampleColour, UndoesAFocusThatMoved) {
  cv::Mat colour(48, 64, CV_8UC3);
  for (int v = 0; v < 48; ++v) {
    for (int u = 0; u < 64; ++u) {
      colour.at<cv::Vec3b>(v, u) =
          cv::Vec3b(static_cast<unsigned char>(2 * u), static_cast<unsigned char>(3 * v), 7);
    }
  }
  const PinholeCamera from = Camera(64, 48, 55.0), to = Camera(64, 48, 50.0);
  const cv::Mat moved = ResampleColour(colour, from, to);
  for (const auto& [u, v] : {std::pair(10, 10), {32, 24}, {50, 40}}) {
    const double u_from = (u - to.cx) * from.fx / to.fx + from.cx;
    const double v_from = (v - to.cy) * from.fy / to.fy + from.cy;
    EXPECT_NEAR(moved.at<cv::Vec3b>(v, u)[0], 2.0 * u_from, 0.6);
    EXPECT_NEAR(moved.at<cv::Vec3b>(v, u)[1], 3.0 * v_from, 0.6);
  }
}

TEST(ResampleDepth, TakesThePixelThatTheCentreLiesIn) {
  const cv::Mat depth = Numbered(256, 192);
  const PinholeCamera from = Camera(1920, 1440, 1352.0);
  const PinholeCamera to = ResizedCamera(from, {640, 480});
  const cv::Mat result = ResampleDepth(depth, from, to);
  ASSERT_EQ(result.size(), cv::Size(640, 480));
  ASSERT_EQ(result.type(), CV_16UC1);
  for (int v = 0; v < 480; ++v) {
    for (int u = 0; u < 640; ++u) {
      // 2.5 pixels a pixel; a centre between two belongs to the next one.
      const int row = (2 * v + 1) * 192 / (2 * 480), column = (2 * u + 1) * 256 / (2 * 640);
      ASSERT_EQ(result.at<std::uint16_t>(v, u), depth.at<std::uint16_t>(row, column))
          << u << ", " << v;
    }
  }
}

TEST(ResampleDepth, InventsNoDepthAtEdgesAndHoles) {
  cv::Mat depth(6, 8, CV_32FC1, cv::Scalar(1.0));
  depth.colRange(4, 8).setTo(3.0);
  depth.at<float>(2, 2) = 0.0F;
  const PinholeCamera from = Camera(80, 60, 60.0);
  const cv::Mat result = ResampleDepth(depth, from, from);
  ASSERT_EQ(result.size(), cv::Size(80, 60));
  EXPECT_EQ(cv::countNonZero(result == 0.0), 100);
  EXPECT_EQ(cv::countNonZero(result == 1.0), 80 * 60 / 2 - 100);
  EXPECT_EQ(cv::countNonZero(result == 3.0), 80 * 60 / 2);
}

TEST(ResampleDepth, UndoesAFocusThatMovedAndLeavesTheRimEmpty) {
  const cv::Mat depth = Numbered(64, 48);
  const PinholeCamera from = Camera(64, 48, 40.0), to = Camera(64, 48, 50.0);
  const cv::Mat nearer = ResampleDepth(depth, from, to);
  const auto at = [&](int u, int v) { return nearer.at<std::uint16_t>(v, u); };
  // (10 - 31.5) 0.8 + 31.5 = 14.3, (10 - 23.5) 0.8 + 23.5 = 12.7
  EXPECT_EQ(at(10, 10), depth.at<std::uint16_t>(13, 14));
  EXPECT_EQ(cv::countNonZero(nearer), 64 * 48);
  const cv::Mat wider = ResampleDepth(depth, to, from);
  EXPECT_EQ(wider.at<std::uint16_t>(0, 0), 0);
  EXPECT_GT(wider.at<std::uint16_t>(24, 32), 0);
}

}  // namespace
}  // namespace highwall::colour_to_depth_test
