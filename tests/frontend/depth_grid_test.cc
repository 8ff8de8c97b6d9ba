#include <cmath>
#include <limits>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include <highwall/core/error.h>

#include "features/depth_grid.h"

namespace highwall::depth_grid_test {
namespace {

const PinholeCamera kCamera{.k1 = 0.26, .k2 = -0.95, .p1 = -0.005, .p2 = 0.003, .k3 = 1.16};

TEST(DepthGrid, IsTheImageInCoarseCells) {
  const DepthGrid grid{PinholeCamera()};
  EXPECT_EQ(grid.camera().width, 80);
  EXPECT_EQ(grid.camera().height, 60);
  EXPECT_EQ(grid.cell_size(), 8.0);
  // The centre of the first cell is that of pixels 0 to 7.
  EXPECT_EQ(grid.CellOf({3.5, 3.5}), cv::Point(0, 0));
  EXPECT_EQ(grid.CellOf({7.4, 7.6}), cv::Point(0, 1));
  EXPECT_EQ(grid.CellOf({-5.0, 700.0}), cv::Point(0, 59));
  const PinholeCamera camera;
  EXPECT_NEAR((camera.Unproject({3.5, 3.5}, 1.0) - grid.camera().Unproject({0, 0}, 1.0)).norm(),
              0.0, 1e-12);
  EXPECT_NEAR((grid.Ray({7, 9}).cast<double>() - grid.camera().Unproject({7, 9}, 1.0)).norm(), 0.0,
              1e-6);  // single precision
  EXPECT_NEAR((grid.Project(2.0F * grid.Ray({7, 9})) - Eigen::Vector2f(7, 9)).norm(), 0.0F, 1e-4F);
}

// Cells subtend the same angle however the camera is held.
TEST(DepthGrid, APortraitImageHasTheCellsOfItsLandscape) {
  const DepthGrid grid{PinholeCamera{.width = 480, .height = 640, .cx = 239.5, .cy = 319.5}};
  EXPECT_EQ(grid.camera().width, 60);
  EXPECT_EQ(grid.camera().height, 80);
  EXPECT_EQ(grid.cell_size(), 8.0);
  const cv::Mat cells = grid.Sample(cv::Mat(640, 480, CV_32FC1, 2.0F), 0.3, 8.0);
  EXPECT_EQ(cells.size(), cv::Size(60, 80));
  EXPECT_EQ(cv::countNonZero(cells), 60 * 80);
}

TEST(DepthGrid, ItsSizeIsKnownWithoutIt) {
  for (const cv::Size& image : {cv::Size(640, 480), cv::Size(480, 640), cv::Size(640, 12),
                                cv::Size(1, 1000), cv::Size(97, 79)}) {
    const PinholeCamera camera{.width = image.width, .height = image.height};
    const DepthGrid grid(camera);
    EXPECT_EQ(DepthGrid::SizeFor(camera), cv::Size(grid.camera().width, grid.camera().height));
  }
  EXPECT_EQ(DepthGrid::SizeFor({.width = 640, .height = 12}), cv::Size(80, 1));
  EXPECT_EQ(DepthGrid::SizeFor({.width = 1, .height = 1000}), cv::Size(1, 80)) << "at least one";
  EXPECT_THROW(DepthGrid::SizeFor({.width = 0}), InvalidArgument);
}

TEST(DepthGrid, SamplesTheMedianAndLeavesOutWhatIsNotMeasured) {
  const DepthGrid grid{PinholeCamera()};
  cv::Mat depth(480, 640, CV_32FC1, 2.0F);
  depth(cv::Rect(0, 0, 320, 480)).setTo(3.0F);
  depth.at<float>(4, 4) = 9.0F;  // an outlier
  depth(cv::Rect(80, 80, 8, 8)).setTo(0.0F);
  depth(cv::Rect(160, 80, 8, 8)).setTo(std::numeric_limits<float>::quiet_NaN());
  depth(cv::Rect(240, 80, 8, 8)).setTo(20.0F);  // beyond the range
  const cv::Mat cells = grid.Sample(depth, 0.3, 8.0);
  ASSERT_EQ(cells.size(), cv::Size(80, 60));
  EXPECT_EQ(cells.at<float>(0, 0), 3.0F);
  EXPECT_EQ(cells.at<float>(0, 79), 2.0F);
  for (const int u : {10, 20, 30}) EXPECT_EQ(cells.at<float>(10, u), 0.0F) << u;
  EXPECT_THROW(grid.Sample(cv::Mat(3, 4, CV_32FC1), 0.3, 8.0), InvalidArgument);
}

TEST(DepthGrid, AveragesGreyLevelsOverTheCell) {
  const DepthGrid grid{PinholeCamera()};
  cv::Mat gray(480, 640, CV_8UC1, cv::Scalar(40));
  gray(cv::Rect(8, 0, 4, 8)).setTo(200);  // half of the second cell
  const cv::Mat cells = grid.Average(gray);
  ASSERT_EQ(cells.size(), cv::Size(80, 60));
  EXPECT_EQ(cells.at<unsigned char>(0, 0), 40);
  EXPECT_EQ(cells.at<unsigned char>(0, 1), 120);
  EXPECT_EQ(cells.at<unsigned char>(59, 79), 40);
  EXPECT_THROW(grid.Average(cv::Mat(480, 640, CV_32FC1)), InvalidArgument);
  EXPECT_THROW(grid.Average(cv::Mat(48, 64, CV_8UC1)), InvalidArgument);
}

TEST(DepthGrid, UndoesTheDistortion) {
  const DepthGrid grid{kCamera};
  // Depth encodes the undistorted column.
  cv::Mat depth(480, 640, CV_32FC1);
  for (int v = 0; v < depth.rows; ++v) {
    for (int u = 0; u < depth.cols; ++u) {
      depth.at<float>(v, u) = static_cast<float>(1.0 + kCamera.UndistortPixel({u, v}).x() / 640.0);
    }
  }
  const cv::Mat cells = grid.Sample(depth, 0.1, 8.0);
  for (int u = 5; u < 75; u += 5) {
    // The tolerance is one pixel: cells take the nearest one.
    EXPECT_NEAR(cells.at<float>(30, u), 1.0 + (8.0 * u + 3.5) / 640.0, 1.0 / 640.0) << u;
  }
}

TEST(DepthGrid, MasksThePixelsOfItsCells) {
  cv::Mat cells = cv::Mat::zeros(60, 80, CV_8UC1);
  cells.at<unsigned char>(20, 10) = 255;
  const cv::Mat plain = DepthGrid(PinholeCamera()).ToImage(cells);
  EXPECT_EQ(cv::countNonZero(plain), 64);
  EXPECT_EQ(cv::countNonZero(plain(cv::Rect(80, 160, 8, 8))), 64);
  const cv::Mat bent = DepthGrid(kCamera).ToImage(cells);
  const Eigen::Vector2d middle =
      kCamera.Project(kCamera.WithoutDistortion().Unproject({83.5, 163.5}, 1.0));
  EXPECT_EQ(bent.at<unsigned char>(static_cast<int>(std::lround(middle.y())),
                                   static_cast<int>(std::lround(middle.x()))),
            255);
  EXPECT_THROW(DepthGrid(kCamera).ToImage(plain), InvalidArgument);
}

TEST(FindSurfaces, PartsThemAtStepsAndWhereNothingIsMeasured) {
  cv::Mat cells(6, 10, CV_32FC1, cv::Scalar(2.0));
  for (int v = 0; v < cells.rows; ++v) {
    for (int u = 0; u < cells.cols; ++u) cells.at<float>(v, u) += 0.08F * static_cast<float>(u);
  }
  cells(cv::Rect(2, 1, 3, 2)).setTo(1.5F);   // a plate in front of a slanted wall
  cells(cv::Rect(0, 4, 10, 1)).setTo(0.0F);  // a gap
  const DepthSurfaces surfaces = FindSurfaces(cells, 0.05);
  EXPECT_EQ(surfaces.sizes, (std::vector<int>{40 - 6, 6, 10}));
  EXPECT_EQ(surfaces.labels.at<int>(0, 0), 0);
  EXPECT_EQ(surfaces.labels.at<int>(3, 9), 0) << "around the plate";
  EXPECT_EQ(surfaces.labels.at<int>(2, 4), 1);
  EXPECT_EQ(surfaces.labels.at<int>(4, 5), -1);
  EXPECT_EQ(surfaces.labels.at<int>(5, 0), 2);
  // A cell of the slanted wall is 8 cm farther than its neighbour.
  EXPECT_GT(FindSurfaces(cells, 0.02).sizes.size(), 20U);
  EXPECT_THROW(FindSurfaces(cv::Mat::zeros(6, 10, CV_8UC1), 0.05), InvalidArgument);
}

}  // namespace
}  // namespace highwall::depth_grid_test
