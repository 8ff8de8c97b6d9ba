#include <cmath>
#include <limits>
#include <memory>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include <highwall/core/error.h>

#include "features/row_times.h"
#include "support/synthetic_scene.h"

namespace highwall::row_times_test {
namespace {

using testing::Look;
using testing::MakeScene;
using testing::Scene;
using testing::SyntheticView;

// A fast hand-held motion: 0.6 m/s and 80 degrees a second.
const Twist kMotion{.v = {0.5, -0.3, 0.2}, .omega = {0.6, 1.2, -0.4}};

constexpr ReadoutDirection kDirections[] = {ReadoutDirection::kDown, ReadoutDirection::kUp,
                                            ReadoutDirection::kRight, ReadoutDirection::kLeft};

// Depth of the plane n^T p = d from a camera that has moved by T since.
class Plane {
 public:
  double Depth(const PinholeCamera& camera, const Pose& T, int u, int v) const {
    const Eigen::Vector3d ray = T.q() * camera.Unproject({u, v}, 1.0);
    return (d_ - n_.dot(T.p())) / n_.dot(ray);
  }

 private:
  Eigen::Vector3d n_ = Eigen::Vector3d(0.3, -0.2, 1.0).normalized();
  double d_ = 2.0;  // [m]
};

TEST(Twist, LeadsWhereItWasMeasured) {
  const Pose T_AB = Pose::FromTangent({0.19, -0.02, 0.05}, {0.05, 0.28, -0.03});
  const Twist twist = Twist::Between(T_AB, 0.1);
  EXPECT_LT((twist.Over(0.1).p() - T_AB.p()).norm(), 1e-14);
  EXPECT_LT((twist.Over(0.1).Inverse() * T_AB).Angle(), 1e-14);
  // The motion is also inverted.
  EXPECT_LT((twist.Over(-0.1) * T_AB).p().norm(), 1e-14);
}

TEST(Twist, FlowIsTheVelocityOfAPointAtRest) {
  const Eigen::Vector3d p_C(0.4, -0.3, 1.7);
  constexpr double kStep = 1e-6;  // [s] central: relative errors of 1e-12, rounding of 1e-10
  const Eigen::Vector3d flow =
      (kMotion.Over(kStep).Inverse() * p_C - kMotion.Over(-kStep).Inverse() * p_C) / (2.0 * kStep);
  EXPECT_LT((kMotion.Flow(p_C) - flow).norm(), 1e-8);
}

TEST(RowTime, RunsFromTheFirstPixelOfItsDirection) {
  const PinholeCamera camera{.width = 100, .height = 80};
  const Eigen::Vector2d uv(20.0, 60.0);
  EXPECT_EQ(RowTime(uv, camera, ReadoutDirection::kDown), 0.25);
  EXPECT_EQ(RowTime(uv, camera, ReadoutDirection::kUp), 19.0 / 80.0 - 0.5);
  EXPECT_EQ(RowTime(uv, camera, ReadoutDirection::kRight), -0.3);
  EXPECT_EQ(RowTime(uv, camera, ReadoutDirection::kLeft), 0.79 - 0.5);
}

class DepthAtTimeOfDirection : public ::testing::TestWithParam<ReadoutDirection> {};

TEST_P(DepthAtTimeOfDirection, LateDepthBecomesThatOfTheMiddleRow) {
  const PinholeCamera camera{.fx = 525.0, .fy = 535.0, .cx = 310.0};
  constexpr double kDelay = 0.01, kReadout = 0.015;  // [s]
  const Plane plane;
  cv::Mat late(camera.height, camera.width, CV_32FC1), truth = late.clone();
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const Pose T = kMotion.Over(kDelay + kReadout * RowTime({u, v}, camera, GetParam()));
      late.at<float>(v, u) = static_cast<float>(plane.Depth(camera, T, u, v));
      truth.at<float>(v, u) = static_cast<float>(plane.Depth(camera, Pose(), u, v));
    }
  }
  const cv::Mat moved = DepthAtTime(late, camera, kMotion, kDelay, kReadout, GetParam());
  const cv::Rect inner(60, 60, camera.width - 120, camera.height - 120);
  double before = 0.0, after = 0.0;
  for (int v = inner.y; v < inner.br().y; ++v) {
    for (int u = inner.x; u < inner.br().x; ++u) {
      const double z = static_cast<double>(truth.at<float>(v, u));
      before = std::max(before, std::abs(static_cast<double>(late.at<float>(v, u)) - z));
      after = std::max(after, std::abs(static_cast<double>(moved.at<float>(v, u)) - z));
    }
  }
  // The plane rises by up to 4 mm a pixel, and a reading is half a pixel off; the second-order
  // error of the motion, which is larger on the side that is read last, is below a pixel.
  EXPECT_LT(after, 5e-3);
  EXPECT_GT(before, 15e-3);
}

INSTANTIATE_TEST_SUITE_P(Directions, DepthAtTimeOfDirection, ::testing::ValuesIn(kDirections));

TEST(DepthAtTime, UnmeasuredPixelsStaySoAndWithoutMotionNothingChanges) {
  const PinholeCamera camera{.width = 64, .height = 48, .fx = 50, .fy = 50, .cx = 31, .cy = 23};
  cv::Mat depth(48, 64, CV_32FC1, cv::Scalar(2.0));
  depth(cv::Rect(10, 10, 5, 5)) = 0.0;
  const cv::Mat same = DepthAtTime(depth, camera, {}, 0.02, 0.03);
  EXPECT_EQ(cv::countNonZero(same != depth), 0);
  const cv::Mat forward = DepthAtTime(depth, camera, {.v = {0.0, 0.0, 0.5}}, 0.02, 0.0);
  EXPECT_EQ(forward.at<float>(12, 12), 0.0F);
  EXPECT_NEAR(static_cast<double>(forward.at<float>(30, 30)), 2.01, 1e-6);
  EXPECT_THROW(DepthAtTime(cv::Mat(48, 64, CV_16UC1), camera, {}, 0.02, 0.0), InvalidArgument);
}

// Returns the view of a rolling shutter that is read out over `readout` while the camera moves by
// kMotion: the row gives the time, and the time the point's position, which a few iterations make
// consistent.
SyntheticView SeenByRows(const Scene& scene, const RgbdSensor& sensor, double readout,
                         ReadoutDirection direction = ReadoutDirection::kDown) {
  SyntheticView view = Look(scene, sensor, Pose());
  auto seen = std::make_shared<FrameFeatures>(*view.features);
  const auto see = [&](const Eigen::Vector3d& p_C, Eigen::Vector2d uv) {
    Eigen::Vector3d p;
    for (int round = 0; round < 30; ++round) {
      p = kMotion.Over(readout * RowTime(uv, sensor.camera, direction)).Inverse() * p_C;
      uv = sensor.camera.Project(p);
    }
    return p;
  };
  for (PointFeature& point : seen->points) {
    const Eigen::Vector3d p = see(sensor.camera.Unproject(point.uv, point.depth), point.uv);
    point.uv = sensor.camera.Project(p);
    point.depth = p.z();
  }
  for (LineFeature& line : seen->lines) {
    line.segment_C->p_C = see(line.segment_C->p_C, line.segment.s.cast<double>());
    line.segment_C->q_C = see(line.segment_C->q_C, line.segment.e.cast<double>());
    line.segment.s = sensor.camera.Project(line.segment_C->p_C).cast<float>();
    line.segment.e = sensor.camera.Project(line.segment_C->q_C).cast<float>();
  }
  view.features = seen;
  return view;
}

TEST(CompensatedToMiddleRow, FeaturesAreWhereOneMomentWouldHaveSeenThem) {
  const RgbdSensor sensor = testing::IdealSensor();
  const Scene scene = MakeScene(3, 300, 30);
  const SyntheticView truth = Look(scene, sensor, Pose());
  const SyntheticView seen = SeenByRows(scene, sensor, 0.03);
  const auto moved = CompensatedToMiddleRow(*seen.features, sensor.camera, 0.03, kMotion);
  ASSERT_EQ(moved->points.size(), truth.features->points.size());
  double shift = 0.0;
  for (std::size_t i = 0; i < moved->points.size(); ++i) {
    const PointFeature &a = moved->points[i], &b = truth.features->points[i];
    EXPECT_LT((a.uv - b.uv).norm(), 1e-9);  // [px] double rounding
    EXPECT_NEAR(a.depth, b.depth, 1e-12);
    shift = std::max(shift, (seen.features->points[i].uv - b.uv).norm());
  }
  EXPECT_GT(shift, 5.0);
  ASSERT_FALSE(moved->lines.empty());
  for (std::size_t i = 0; i < moved->lines.size(); ++i) {
    const LineFeature &a = moved->lines[i], &b = truth.features->lines[i];
    // Ends are stored as floats, 3e-5 px, which determine the row's time as well.
    EXPECT_LT((a.segment.s - b.segment.s).norm(), 1e-4F);
    EXPECT_LT((a.segment.e - b.segment.e).norm(), 1e-4F);
    EXPECT_LT((a.segment_C->p_C - b.segment_C->p_C).norm(), 1e-6);
    EXPECT_LT((a.segment_C->q_C - b.segment_C->q_C).norm(), 1e-6);
  }
}

TEST(CompensatedToMiddleRow, FollowsTheDirectionOfTheReadout) {
  const RgbdSensor sensor = testing::IdealSensor();
  const Scene scene = MakeScene(3, 300, 0);
  const SyntheticView truth = Look(scene, sensor, Pose());
  for (const ReadoutDirection direction : kDirections) {
    const SyntheticView seen = SeenByRows(scene, sensor, 0.03, direction);
    const auto moved =
        CompensatedToMiddleRow(*seen.features, sensor.camera, 0.03, kMotion, direction);
    for (std::size_t i = 0; i < moved->points.size(); ++i) {
      ASSERT_LT((moved->points[i].uv - truth.features->points[i].uv).norm(), 1e-9)
          << ToString(direction);
    }
  }
}

TEST(MovedOtherwise, AnAssumedMotionIsReplacedByTheOneThatWasFound) {
  const RgbdSensor sensor = testing::IdealSensor();
  const DepthGrid grid(sensor.camera);
  const Scene scene = MakeScene(3, 300, 0);
  const SyntheticView seen = SeenByRows(scene, sensor, 0.03);
  const Twist assumed{.v = {0.3, -0.2, 0.1}, .omega = {0.3, 0.9, -0.3}};
  // Depth is measured at the time of its pixel.
  const FrameTiming timing{.colour_readout = 0.03, .depth_readout = 0.03};
  const auto first = CompensatedToMiddleRow(*seen.features, sensor.camera, 0.03, assumed);
  const auto second =
      MovedOtherwise(*first, sensor.camera, grid, {timing, assumed}, {timing, kMotion});
  const auto direct = CompensatedToMiddleRow(*seen.features, sensor.camera, 0.03, kMotion);
  for (std::size_t i = 0; i < second->points.size(); ++i) {
    // The row that a feature is moved to approximates the one it was seen in: 10 px of 480 of 30
    // ms, times the difference of the flows, 0.4 rad/s of 525 px.
    EXPECT_LT((second->points[i].uv - direct->points[i].uv).norm(), 0.2);
  }
}

TEST(MovedOtherwise, LateDepthFollowsTheMotionThatWasFound) {
  // A wall that faces an approaching camera: depth 20 ms late is 10 mm short, and was assumed to be
  // 4 mm short.
  const PinholeCamera camera;
  const DepthGrid grid(camera);
  const FrameTiming late{.depth_delay = 0.02};
  FrameFeatures features;
  features.points.push_back({.uv = {400.0, 100.0}, .depth = 1.99 + 0.004, .depth_sigma = 0.01});
  features.depth_grid = cv::Mat(DepthGrid::SizeFor(camera), CV_32FC1, cv::Scalar(1.99));
  const auto moved = MovedOtherwise(features, camera, grid, {late, {.v = {0.0, 0.0, 0.2}}},
                                    {late, {.v = {0.0, 0.0, 0.5}}});
  EXPECT_NEAR(moved->points[0].depth, 2.0, 1e-12);
  EXPECT_LT((moved->points[0].uv - features.points[0].uv).norm(), 1e-9);
}

TEST(MovedOtherwise, FeaturesThatNothingMovedFollowATimingThatIsLearntLater) {
  const RgbdSensor sensor = testing::IdealSensor();
  const DepthGrid grid(sensor.camera);
  const Scene scene = MakeScene(3, 300, 30);
  const SyntheticView seen = SeenByRows(scene, sensor, 0.03);
  const RowMotion found{{.colour_readout = 0.03, .depth_readout = 0.03}, kMotion};
  const auto moved = MovedOtherwise(*seen.features, sensor.camera, grid, {}, found);
  const SyntheticView truth = Look(scene, sensor, Pose());
  ASSERT_EQ(moved->points.size(), truth.features->points.size());
  for (std::size_t i = 0; i < moved->points.size(); ++i) {
    EXPECT_LT((moved->points[i].uv - truth.features->points[i].uv).norm(), 1e-9);
    EXPECT_NEAR(moved->points[i].depth, truth.features->points[i].depth, 1e-12);
  }
}

TEST(RowMotion, DiffersWhereATenthOfAPixelDoes) {
  const PinholeCamera camera;  // f = 525 px
  const FrameTiming timing{.colour_readout = 0.03, .depth_readout = 0.03};
  const RowMotion at_rest{timing, {}};
  const auto turning = [&](double rate) { return RowMotion{timing, {.omega = {0, rate, 0}}}; };
  // 15 ms from the middle row to the first: 0.1 px at 0.0127 rad/s.
  EXPECT_FALSE(Differ(at_rest, turning(0.0126), camera, 2.0));
  EXPECT_TRUE(Differ(at_rest, turning(0.0128), camera, 2.0));
  EXPECT_FALSE(Differ(turning(1.0), turning(1.0), camera, 2.0));
  const RowMotion moving{timing, {.v = {0.05, 0, 0}}};
  EXPECT_TRUE(Differ(at_rest, moving, camera, 2.0));
  EXPECT_FALSE(Differ(at_rest, moving, camera, std::numeric_limits<double>::infinity()));
  RowMotion late = moving;
  late.timing.depth_delay = 0.02;
  EXPECT_TRUE(Differ(moving, late, camera, 2.0));
}

TEST(DepthRate, OfASlopeIsThatOfItsReading) {
  const PinholeCamera camera;
  const DepthGrid grid(camera);
  const Plane plane;
  cv::Mat cells(DepthGrid::SizeFor(camera), CV_32FC1);
  for (int v = 0; v < cells.rows; ++v) {
    for (int u = 0; u < cells.cols; ++u) {
      cells.at<float>(v, u) = static_cast<float>(plane.Depth(grid.camera(), Pose(), u, v));
    }
  }
  const Eigen::Vector3d p_C =
      grid.camera().Unproject({30, 20}, plane.Depth(grid.camera(), Pose(), 30, 20));
  constexpr double kStep = 1e-5;  // [s]
  const double rate = (plane.Depth(grid.camera(), kMotion.Over(kStep), 30, 20) -
                       plane.Depth(grid.camera(), kMotion.Over(-kStep), 30, 20)) /
                      (2.0 * kStep);
  // The slope is computed over two cells, 16 px: a hundredth of it is curvature of z over the
  // image.
  EXPECT_NEAR(DepthRate(cells, grid, p_C, kMotion).value(), rate, 0.02 * std::abs(rate));
  cells.at<float>(20, 31) = 1.0F;
  EXPECT_FALSE(DepthRate(cells, grid, p_C, kMotion));
}

TEST(CompensatedToMiddleRow, PointsWithoutDepthTurnWithTheCamera) {
  const PinholeCamera camera;
  FrameFeatures features;
  features.points.push_back({.uv = {400.0, 100.0}});
  const auto moved = CompensatedToMiddleRow(features, camera, 0.03, {.omega = {0.0, 0.0, 1.0}});
  const double late = 0.03 * RowTime(100.0, camera.height);
  const Eigen::Vector3d ray = Pose::FromTangent(Eigen::Vector3d::Zero(), {0.0, 0.0, late}).q() *
                              camera.Unproject({400.0, 100.0}, 1.0);
  EXPECT_LT((moved->points[0].uv - camera.Project(ray)).norm(), 1e-9);
  EXPECT_EQ(moved->points[0].depth, 0.0);
}

}  // namespace
}  // namespace highwall::row_times_test
