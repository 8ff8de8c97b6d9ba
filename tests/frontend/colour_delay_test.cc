#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "painted_world.h"
#include "sensor/colour_delay.h"

namespace highwall::colour_delay_test {
namespace {

using testing::kBoxes;
using testing::kGrid;
using testing::kGridCamera;

constexpr Stamp kInterval = 33'333'333;  // [ns]

// Turns by 1.7 degrees and moves by 15 mm an image, as a camera by hand in a fast turn.
Pose CameraAt(int image) {
  return Pose::FromTangent({0.012 * image, -0.009 * image, 0.0}, {0.0, 0.03 * image, 0.0});
}

cv::Mat ColourAt(int image) {
  const Pose T_WC = CameraAt(image);
  const cv::Mat depth = testing::DepthOf(kBoxes, kGridCamera, T_WC);
  cv::Mat grey(depth.size(), CV_8UC1), bgr;
  for (int v = 0; v < grey.rows; ++v) {
    for (int u = 0; u < grey.cols; ++u) {
      const double z = static_cast<double>(depth.at<float>(v, u));
      const Eigen::Vector3d p_W = T_WC * kGridCamera.Unproject({u, v}, z);
      grey.at<std::uint8_t>(v, u) = cv::saturate_cast<std::uint8_t>(testing::Paint(p_W, 0.0));
    }
  }
  cv::cvtColor(grey, bgr, cv::COLOR_GRAY2BGR);
  return bgr;
}

std::shared_ptr<const FrameFeatures> GridsOf(const RgbdImage& image) {
  auto features = std::make_shared<FrameFeatures>();
  cv::Mat grey;
  cv::cvtColor(image.bgr, grey, cv::COLOR_BGR2GRAY);
  features->gray_grid = kGrid.Average(grey);
  features->depth_grid = kGrid.Sample(image.depth, 0.3, 8.0);
  return features;
}

// Gives one image after the other; colours[i]: the image at whose time the colour of image i was
// taken. Returns for each that repeats none whose depth it is given.
std::vector<int> DepthsGiven(const std::vector<int>& colours) {
  RgbdSensor sensor;
  sensor.min_depth = 0.3;
  sensor.max_depth = 8.0;
  ColourDelay delay(sensor, kGrid);
  const Twist motion = Twist::Between(CameraAt(0).Inverse() * CameraAt(1), ToSeconds(kInterval));
  std::vector<cv::Mat> depths;
  std::vector<int> given;
  for (std::size_t i = 0; i < colours.size(); ++i) {
    const bool repeated = i > 0 && colours[i] == colours[i - 1];
    depths.push_back(testing::DepthOf(kBoxes, kGridCamera, CameraAt(static_cast<int>(i))));
    RgbdImage image;
    image.stamp = static_cast<Stamp>(i) * kInterval;
    const cv::Mat memory = depths.back().clone();
    image.depth = memory;
    if (!repeated) image.bgr = ColourAt(colours[i]);
    delay.Apply(repeated, motion, &image);
    if (!repeated) {
      delay.SetReference(GridsOf(image));
      for (std::size_t k = 0; k < depths.size(); ++k) {
        if (cv::norm(depths[k], image.depth, cv::NORM_INF) == 0.0) {
          given.push_back(static_cast<int>(k));
        }
      }
    }
    cv::Mat(memory).setTo(0.0);  // as a camera that writes the next image into it
    if (repeated) continue;
    EXPECT_EQ(delay.delay(), image.stamp - given.back() * kInterval);
  }
  return given;
}

TEST(ColourDelay, DepthOfAnImageIsThatOfItsStampWhereNoImageIsRepeated) {
  EXPECT_EQ(DepthsGiven({0, 1, 2, 3}), (std::vector<int>{0, 1, 2, 3}));
}

TEST(ColourDelay, DepthOfLateColourIsThatOfItsTime) {
  EXPECT_EQ(DepthsGiven({0, 1, 1, 2, 2, 4, 4, 6}), (std::vector<int>{0, 1, 2, 4, 6}));
}

TEST(ColourDelay, RepeatedImagesMakeColourEverLater) {
  EXPECT_EQ(DepthsGiven({0, 1, 1, 2, 2, 3, 3, 4}), (std::vector<int>{0, 1, 2, 3, 4}));
}

TEST(ColourDelay, ColourThatCatchesUpIsLateNoMore) {
  EXPECT_EQ(DepthsGiven({0, 1, 1, 2, 2, 4, 6, 7}), (std::vector<int>{0, 1, 2, 4, 6, 7}));
}

TEST(ColourDelay, ColourThatIsNotLateAfterARepeatedImageKeepsItsDepth) {
  EXPECT_EQ(DepthsGiven({0, 1, 1, 3, 4}), (std::vector<int>{0, 1, 3, 4}));
}

}  // namespace
}  // namespace highwall::colour_delay_test
