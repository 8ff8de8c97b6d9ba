// SlamSystem with loops on a walk around a room and on. Takes some ten seconds.
#include <cmath>
#include <memory>
#include <span>
#include <vector>

#include <gtest/gtest.h>
#include <highwall/core/trajectory_error.h>
#include <highwall/frontend/system/slam_system.h>
#include <simulate/scenes/room.h>

#include "support/rendered_walk.h"

namespace highwall::slam_loop_test {
namespace {

using testing::RenderedWalk;

constexpr double kLap = 10.0, kSeconds = 15.0, kFps = 10.0;
constexpr auto kLapFrames = static_cast<std::size_t>(kLap * kFps);

class SlamLoopTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    simulate::SimulationOptions options;
    options.seed = 5;
    options.duration = kSeconds;
    options.fps = kFps;
    options.camera = Camera();
    options.sensor.noise = simulate::SensorNoise::kKinect;
    options.sensor.noise_ratio = 1.0;  // the bounds below are for the specified noise
    const simulate::Simulation room(simulate::MakeRoom(options.seed),
                                    simulate::MakeRoomTrajectory(kLap, options.seed), options);
    walk_ = std::make_unique<RenderedWalk>(testing::Render(room));
  }
  static void TearDownTestSuite() { walk_.reset(); }

  static PinholeCamera Camera() {
    return {.width = 320, .height = 240, .fx = 262.5, .fy = 262.5, .cx = 159.5, .cy = 119.5};
  }

  struct Run {
    std::vector<LoopReport> loops;
    std::size_t before_end = 0;  // loops reported before Finish()
    int lost = 0, reported_loops = 0, reported_maps = 0;
    double rmse = 0.0;     // [m] APE
    double closure = 0.0;  // [m] RMS error between each place and its revisit
    std::vector<Eigen::Matrix4d> poses;
  };
  // wait: for other threads, after every frame. frames: of the beginning, and no more.
  static Run Walk(const LoopCloserOptions& loops, int threads, bool wait = false,
                  std::size_t frames = static_cast<std::size_t>(kSeconds * kFps)) {
    SlamOptions options;
    options.loops = loops;
    options.threads = threads;
    SlamSystem slam({.camera = Camera()}, options);
    Run run;
    slam.SetCallbacks({.on_loop = [&](const LoopReport&) { ++run.reported_loops; },
                       .on_map = [&](const Map&) { ++run.reported_maps; }});
    const auto keep = [&](const std::vector<LoopReport>& reports) {
      run.loops.insert(run.loops.end(), reports.begin(), reports.end());
    };
    for (const RgbdImage& image : std::span(walk_->images).first(frames)) {
      const FrameResult result = slam.Track(image);
      if (result.state != TrackingState::kTracking) ++run.lost;
      keep(result.loops);
      if (wait) keep(slam.Finish());
    }
    run.before_end = run.loops.size();
    keep(slam.Finish());
    EXPECT_TRUE(slam.Finish().empty()) << "a second time";
    for (const StampedPose& pose : slam.trajectory()) run.poses.push_back(pose.pose.Matrix());
    run.rmse = AbsolutePoseError(walk_->truth, slam.trajectory()).statistics.rmse;
    if (run.lost == 0 && frames > kLapFrames) run.closure = Closure(slam.trajectory());
    return run;
  }

  // All frames must have a pose.
  static double Closure(const Trajectory& estimate) {
    double sum = 0.0;
    for (std::size_t i = kLapFrames; i < estimate.size(); ++i) {
      const Pose way = estimate[i - kLapFrames].pose.Inverse() * estimate[i].pose;
      const Trajectory& truth = walk_->truth;
      const Pose true_way = truth[i - kLapFrames].pose.Inverse() * truth[i].pose;
      sum += (way.p() - true_way.p()).squaredNorm();
    }
    return std::sqrt(sum / static_cast<double>(estimate.size() - kLapFrames));
  }

  static std::unique_ptr<const RenderedWalk> walk_;
};

std::unique_ptr<const RenderedWalk> SlamLoopTest::walk_;

TEST_F(SlamLoopTest, ClosesTheLoopAndTheTrackerFollows) {
  LoopCloserOptions closing;
  const Run with = Walk(closing, 0);
  ASSERT_GE(with.loops.size(), 2u);
  for (const LoopReport& report : with.loops) EXPECT_TRUE(report.accepted) << report.message;
  EXPECT_GT(with.loops[0].fused_points, 20);
  EXPECT_EQ(with.lost, 0) << "the tracker went on in the corrected map";
  LoopCloserOptions off;
  off.enabled = false;
  const Run without = Walk(off, 0);
  EXPECT_TRUE(without.loops.empty());
  EXPECT_LT(with.rmse, 0.006);
  EXPECT_LT(with.rmse, without.rmse);
  EXPECT_EQ(Walk(closing, 0).poses, with.poses) << "bit for bit";
}

// No keyframes are left to confirm the place.
TEST_F(SlamLoopTest, ClosesTheLoopOfARecordingThatEndsWhereItBegan) {
  LoopCloserOptions off;
  off.enabled = false;
  const Run without = Walk(off, 0, false, kLapFrames);
  const Run run = Walk({}, 0, false, kLapFrames);
  EXPECT_EQ(run.before_end, 0u);
  ASSERT_EQ(run.loops.size(), 2u) << "the loop, and the adjustment after it";
  EXPECT_TRUE(run.loops[0].accepted) << run.loops[0].message;
  EXPECT_EQ(run.reported_loops, 2);
  EXPECT_EQ(run.reported_maps, 1);
  EXPECT_LT(run.rmse, 0.7 * without.rmse);
  EXPECT_EQ(Walk({}, 0, false, kLapFrames).poses, run.poses) << "bit for bit";
  // Which keyframes there are depends on the machine.
  const Run threaded = Walk({}, 2, false, kLapFrames);
  ASSERT_FALSE(threaded.loops.empty());
  EXPECT_TRUE(threaded.loops.back().accepted) << threaded.loops.back().message;
  EXPECT_LT(threaded.rmse, 0.7 * without.rmse);
}

TEST_F(SlamLoopTest, ClosesTheLoopInTheBackground) {
  const Run run = Walk({}, 2, true);
  ASSERT_FALSE(run.loops.empty());
  EXPECT_TRUE(run.loops[0].accepted) << run.loops[0].message;
  EXPECT_EQ(run.lost, 0);
  EXPECT_LT(run.rmse, 0.006);
  EXPECT_EQ(run.reported_loops, static_cast<int>(run.loops.size()));
  EXPECT_GE(run.reported_maps, 1);
}

TEST_F(SlamLoopTest, TheCameraNeedNotWaitForTheLoop) {
  const Run run = Walk({}, 2);
  ASSERT_FALSE(run.loops.empty());
  EXPECT_TRUE(run.loops[0].accepted) << run.loops[0].message;
  EXPECT_EQ(run.lost, 0);
  // Frames are processed as fast as possible: the keyframe that closes the loop, and the delay of
  // the correction in frames, depend on the machine. Without loops this is 20 mm or more.
  EXPECT_LT(run.closure, 0.012);
}

}  // namespace
}  // namespace highwall::slam_loop_test
