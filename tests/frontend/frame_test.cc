#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include <highwall/core/error.h>
#include <highwall/frontend/features/frame.h>
#include <highwall/frontend/features/lbd_line_extractor.h>
#include <highwall/frontend/features/orb_extractor.h>

#include "features/frame_builder.h"
#include "support/message_of.h"

namespace highwall::frame_test {
namespace {

RgbdSensor SmallSensor() {
  RgbdSensor sensor;
  sensor.camera = {.width = 320, .height = 240, .fx = 262.0, .fy = 262.0, .cx = 159.5, .cy = 119.5};
  return sensor;
}

RgbdSensor DistortedSensor() {
  RgbdSensor sensor = SmallSensor();
  sensor.camera.k1 = 0.2;
  sensor.camera.k2 = -0.5;
  sensor.camera.p1 = -0.003;
  return sensor;
}

// Random grey boxes on a plane whose depth falls from 3 m on the left to 1.4 m on the right.
RgbdImage Boxes() {
  RgbdImage image{.stamp = 1, .bgr = cv::Mat(240, 320, CV_8UC3, cv::Scalar::all(120)), .depth = {}};
  std::mt19937 rng(3);
  for (int i = 0; i < 60; ++i) {
    const cv::Rect box(static_cast<int>(rng() % 300), static_cast<int>(rng() % 220),
                       10 + static_cast<int>(rng() % 50), 10 + static_cast<int>(rng() % 50));
    cv::rectangle(image.bgr, box, cv::Scalar::all(static_cast<double>(rng() % 256)), cv::FILLED);
  }
  image.depth.create(240, 320, CV_32FC1);
  for (int v = 0; v < 240; ++v) {
    for (int u = 0; u < 320; ++u)
      image.depth.at<float>(v, u) = 3.0F - 0.005F * static_cast<float>(u);
  }
  return image;
}

cv::Mat Gray(const RgbdImage& image) {
  cv::Mat gray;
  cv::cvtColor(image.bgr, gray, cv::COLOR_BGR2GRAY);
  return gray;
}

void ExpectSame(const FrameFeatures& a, const FrameFeatures& b) {
  ASSERT_EQ(a.points.size(), b.points.size());
  for (std::size_t i = 0; i < a.points.size(); ++i) {
    EXPECT_EQ(a.points[i].uv, b.points[i].uv);
    EXPECT_EQ(a.points[i].depth, b.points[i].depth);
  }
  EXPECT_EQ(cv::countNonZero(a.point_descriptors != b.point_descriptors), 0);
  ASSERT_EQ(a.lines.size(), b.lines.size());
  for (std::size_t i = 0; i < a.lines.size(); ++i) {
    EXPECT_EQ(a.lines[i].segment.s, b.lines[i].segment.s);
    EXPECT_EQ(a.lines[i].segment.e, b.lines[i].segment.e);
    ASSERT_EQ(a.lines[i].segment_C.has_value(), b.lines[i].segment_C.has_value());
    if (a.lines[i].segment_C) {
      EXPECT_EQ(a.lines[i].segment_C->p_C, b.lines[i].segment_C->p_C);
    }
  }
}

TEST(FrameBuilder, PointsAreTheCornersUndistortedWithTheDepthOfTheRawPixel) {
  const RgbdSensor sensor = DistortedSensor();
  const RgbdImage image = Boxes();
  const FrameBuilderOptions options;
  const auto features = FrameBuilder(sensor, options).Build(image);
  const ExtractedPoints orb = OrbExtractor(options.orb).Extract(Gray(image));
  ASSERT_GT(orb.keypoints.size(), 100u);
  ASSERT_EQ(features->points.size(), orb.keypoints.size());
  ASSERT_EQ(features->point_descriptors.rows, static_cast<int>(orb.keypoints.size()));
  EXPECT_EQ(features->point_grid.size(), orb.keypoints.size());
  for (std::size_t i = 0; i < orb.keypoints.size(); ++i) {
    const cv::KeyPoint& raw = orb.keypoints[i];
    const PointFeature& point = features->points[i];
    EXPECT_EQ(point.uv, sensor.camera.UndistortPixel({raw.pt.x, raw.pt.y}));
    EXPECT_EQ(point.octave, raw.octave);
    EXPECT_EQ(point.angle, raw.angle);
    const auto u = static_cast<int>(std::lround(raw.pt.x)),
               v = static_cast<int>(std::lround(raw.pt.y));
    EXPECT_EQ(point.depth, static_cast<double>(image.depth.at<float>(v, u)));
    // The grid has the point at its undistorted position.
    const auto near = features->point_grid.Query(point.uv, 1e-3, point.octave, point.octave);
    EXPECT_NE(std::find(near.begin(), near.end(), static_cast<int>(i)), near.end());
  }
}

TEST(FrameBuilder, LinesAreUndistortedWithDepthOnThePlane) {
  const RgbdSensor sensor = DistortedSensor();
  const RgbdImage image = Boxes();
  const FrameBuilderOptions options;
  const auto features = FrameBuilder(sensor, options).Build(image);
  LbdLineExtractor extractor(options.lines);
  const LineFeatures raw = extractor.Extract(Gray(image));
  ASSERT_GT(raw.segments.size(), 20u);
  ASSERT_EQ(features->lines.size(), raw.segments.size());
  ASSERT_EQ(features->line_descriptors.rows, static_cast<int>(raw.segments.size()));
  int with_depth = 0;
  for (std::size_t i = 0; i < raw.segments.size(); ++i) {
    const Eigen::Vector2d s = raw.segments[i].s.cast<double>();
    EXPECT_EQ(features->lines[i].segment.s, sensor.camera.UndistortPixel(s).cast<float>());
    if (!features->lines[i].segment_C) continue;
    ++with_depth;
    // The depth image is smooth: the fit is accurate to a fraction of the sensor's noise of 5 mm.
    EXPECT_NEAR(features->lines[i].segment_C->p_C.z(), 3.0 - 0.005 * s.x(), 0.02);
  }
  EXPECT_GT(with_depth, static_cast<int>(raw.segments.size()) / 2);
}

TEST(FrameBuilder, DepthOutOfRangeMissingOrNanIsNone) {
  RgbdSensor sensor = SmallSensor();
  sensor.min_depth = 2.0;  // the right 120 columns are nearer
  sensor.max_depth = 2.7;  // the left 60 columns are farther
  RgbdImage image = Boxes();
  image.depth.rowRange(0, 60).setTo(0.0F);
  image.depth.rowRange(60, 100).setTo(std::nanf(""));
  int with = 0;
  const auto features = FrameBuilder(sensor, {}).Build(image);
  for (const PointFeature& point : features->points) {
    const bool in_range = point.uv.y() > 99.5 && point.uv.x() > 59.5 && point.uv.x() < 200.5;
    if (in_range && point.uv.x() > 61.0 && point.uv.x() < 199.0) {
      EXPECT_GE(point.depth, 2.0);
      EXPECT_LE(point.depth, 2.7);
      ++with;
    }
    if (!in_range) {
      EXPECT_EQ(point.depth, 0.0) << point.uv.transpose();
    }
  }
  EXPECT_GT(with, 20);
}

TEST(FrameBuilder, DepthNoiseGrowsWithTheSpreadAroundACorner) {
  const RgbdSensor sensor = SmallSensor();
  for (const double share : {0.0, 0.5}) {
    RgbdImage image = Boxes();
    for (const char* falls : {"to the right", "down"}) {
      const auto features = FrameBuilder(sensor, {}, nullptr, nullptr, true, share).Build(image);
      for (const PointFeature& point : features->points) {
        ASSERT_GT(point.depth, 0.0);
        // The ramp falls by 5 mm a pixel, in float depths.
        EXPECT_NEAR(point.depth_sigma,
                    std::hypot(sensor.depth_noise.Sigma(point.depth), share * 0.005), 1e-6)
            << falls;
      }
      for (int v = 0; v < image.depth.rows; ++v) {
        image.depth.row(v).setTo(3.0F - 0.005F * static_cast<float>(v));
      }
    }
  }
}

TEST(FrameBuilder, DepthNoiseGrowsWithTheFactorOfItsReading) {
  RgbdImage image = Boxes();
  // A plane: the inverse depth is affine in the pixel, so that all readings beside a line fit.
  for (int u = 0; u < 320; ++u) {
    image.depth.col(u).setTo(1.0 / (1.0 / 3.0 + 0.0005 * u));
  }
  const auto build = [](const RgbdImage& of) {
    return FrameBuilder(SmallSensor(), {}, nullptr, nullptr, true, 0.0).Build(of);
  };
  const auto usual = build(image);
  image.noise_factor = cv::Mat(240, 320, CV_32FC1, cv::Scalar(1.0));
  image.noise_factor.colRange(160, 320).setTo(2.0);
  const auto features = build(image);
  ASSERT_EQ(features->points.size(), usual->points.size());
  for (std::size_t i = 0; i < features->points.size(); ++i) {
    const PointFeature& point = features->points[i];
    const double factor = std::lround(point.pixel.x()) >= 160 ? 2.0 : 1.0;
    EXPECT_DOUBLE_EQ(point.depth_sigma, factor * usual->points[i].depth_sigma);
  }
  int doubled = 0;
  for (std::size_t i = 0; i < features->lines.size(); ++i) {
    const auto &line = features->lines[i].segment_C, &before = usual->lines[i].segment_C;
    const LineSegment& segment = features->lines[i].segment;
    if (!line || !before || std::min(segment.s.x(), segment.e.x()) < 164.0F) continue;
    // The plane is exact: all readings are inliers of the same fit.
    EXPECT_NEAR(line->sigma_p, 2.0 * before->sigma_p, 1e-6 * before->sigma_p);
    ++doubled;
  }
  EXPECT_GT(doubled, 5);
}

TEST(FrameBuilder, RefusesFactorsOfAnotherSizeOrType) {
  RgbdImage image = Boxes();
  image.noise_factor = cv::Mat(24, 32, CV_32FC1, cv::Scalar(1.0));
  EXPECT_THROW(FrameBuilder(SmallSensor(), {}).Build(image), InvalidArgument);
  image.noise_factor = cv::Mat(240, 320, CV_8UC1, cv::Scalar(1.0));
  EXPECT_THROW(FrameBuilder(SmallSensor(), {}).Build(image), InvalidArgument);
}

TEST(FrameBuilder, TwoThreadsAndOneGiveTheSame) {
  FrameBuilderOptions options;
  const RgbdImage image = Boxes();
  FrameBuilder parallel(SmallSensor(), options);
  FrameBuilder serial(SmallSensor(), options, nullptr, nullptr, false);
  const auto first = parallel.Build(image);
  ExpectSame(*first, *serial.Build(image));
  ExpectSame(*first, *parallel.Build(image));
}

TEST(FrameBuilder, DepthChangedBesideTheExtractionIsThatOfAllFeatures) {
  RgbdImage changed = Boxes();
  changed.depth *= 1.25;
  for (const bool parallel : {true, false}) {
    FrameBuilder builder(SmallSensor(), {}, nullptr, nullptr, parallel);
    RgbdImage image = Boxes();
    const cv::Mat as_given = image.depth.clone();
    int times = 0;
    const auto change = [&times](RgbdImage* given) {
      ++times;
      given->depth = 1.25 * given->depth;
    };
    ExpectSame(*builder.Build(&image, change), *builder.Build(changed));
    EXPECT_EQ(times, 1);
    EXPECT_EQ(cv::norm(image.depth, changed.depth, cv::NORM_INF), 0.0);
    ExpectSame(*builder.Build(&image, {}), *builder.Build(changed));
    EXPECT_GT(cv::norm(as_given, image.depth, cv::NORM_INF), 0.0);
  }
}

TEST(FrameBuilder, SkipsFeatureTypesThatAreSwitchedOff) {
  FrameBuilderOptions options;
  options.use_lines = false;
  const auto points = FrameBuilder(SmallSensor(), options).Build(Boxes());
  EXPECT_FALSE(points->points.empty());
  EXPECT_TRUE(points->lines.empty());
  options.use_lines = true;
  options.use_points = false;
  const auto lines = FrameBuilder(SmallSensor(), options).Build(Boxes());
  EXPECT_TRUE(lines->points.empty());
  EXPECT_FALSE(lines->lines.empty());
  EXPECT_TRUE(lines->point_grid.Query({160, 120}, 500, 0, 7).empty());
}

TEST(FrameBuilder, ReportsItsTimes) {
  FrameBuilderTimes times;
  FrameBuilder(SmallSensor(), {}).Build(Boxes(), &times);
  EXPECT_GT(times.points, 0.0);
  EXPECT_GT(times.lines, 0.0);
}

TEST(FrameBuilder, BlankImageHasNoFeatures) {
  RgbdImage image = Boxes();
  image.bgr.setTo(cv::Scalar::all(90));
  const auto features = FrameBuilder(SmallSensor(), {}).Build(image);
  EXPECT_TRUE(features->points.empty());
  EXPECT_TRUE(features->lines.empty());
}

// In pure noise FAST finds corners down to the noise level: each is marked as possibly noise.
TEST(FrameFeatures, SelectKeepsTheFlaggedFeaturesOfAllKindsInOrder) {
  FrameFeatures features;
  features.points.resize(3);
  features.lines.resize(3);
  features.point_descriptors = cv::Mat(3, 32, CV_8U);
  for (int i = 0; i < 3; ++i) {
    features.points[static_cast<std::size_t>(i)].octave = i;
    features.lines[static_cast<std::size_t>(i)].noise.px = static_cast<float>(i);
    features.point_descriptors.row(i).setTo(i);
  }
  features.sharpness = 7.0;
  const auto selected =
      Select(features, {{true, false, true}, {false, true, true}}, cv::Size(320, 240));
  ASSERT_EQ(selected->points.size(), 2U);
  ASSERT_EQ(selected->lines.size(), 2U);
  EXPECT_EQ(selected->points[1].octave, 2);
  EXPECT_EQ(selected->lines[0].noise.px, 1.0F);
  EXPECT_EQ(selected->point_descriptors.rows, 2);
  EXPECT_EQ(selected->point_descriptors.at<std::uint8_t>(1, 0), 2);
  EXPECT_TRUE(selected->line_descriptors.empty());
  EXPECT_EQ(selected->point_grid.size(), 2U);
  EXPECT_EQ(selected->sharpness, 7.0);
}

TEST(FrameBuilder, CornersOfNoiseHaveLowContrast) {
  const RgbdSensor sensor = SmallSensor();
  const cv::Size size(sensor.camera.width, sensor.camera.height);
  cv::RNG rng(4);
  cv::Mat noise(size, CV_16SC3), bgr;
  rng.fill(noise, cv::RNG::NORMAL, 0.0, 2.4);
  cv::add(noise, cv::Scalar::all(110), bgr, cv::noArray(), CV_8UC3);
  const auto features =
      FrameBuilder(sensor, {}).Build({0, bgr, cv::Mat(size, CV_32FC1, cv::Scalar(2.0))});
  ASSERT_GT(features->points.size(), 50U);
  const auto low_contrast = std::count_if(features->points.begin(), features->points.end(),
                                          [](const PointFeature& p) { return p.low_contrast; });
  EXPECT_GE(static_cast<std::size_t>(low_contrast) + 5, features->points.size());
}

TEST(FrameBuilder, RefusesImagesThatDoNotFit) {
  FrameBuilder builder(SmallSensor(), {});
  const RgbdImage good = Boxes();
  const auto refuses = [&](const cv::Mat& bgr, const cv::Mat& depth) {
    EXPECT_THROW(builder.Build({.stamp = 1, .bgr = bgr, .depth = depth}), InvalidArgument);
  };
  refuses(Gray(good), good.depth);
  refuses(good.bgr, cv::Mat(240, 320, CV_16UC1));
  refuses(good.bgr, good.depth.colRange(0, 319));
  refuses(good.bgr.rowRange(0, 200), good.depth.rowRange(0, 200));
  refuses(cv::Mat(), cv::Mat());
}

TEST(FrameBuilderOptions, PointsOrLinesAreWanted) {
  const FrameBuilderOptions neither{.use_points = false, .use_lines = false};
  testing::ExpectError("use_points", [&] { neither.Validate(); });
}

}  // namespace
}  // namespace highwall::frame_test
