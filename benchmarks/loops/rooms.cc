#include "bench_loops.h"

#include <algorithm>
#include <string>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include <highwall/core/error.h>
#include <highwall/core/trajectory_error.h>
#include <highwall/frontend/slam_system.h>
#include <simulate/room.h>

namespace highwall::bench {
namespace {

// The pixels of a Kinect halved: rendering is what the benchmark would else spend its time on.
PinholeCamera SmallCamera() {
  return {.width = 320, .height = 240, .fx = 262.5, .fy = 262.5, .cx = 159.5, .cy = 119.5};
}

simulate::Simulation MakeRoom(int seed, double seconds) {
  simulate::SimulationOptions options;
  options.seed = static_cast<std::uint64_t>(seed);
  options.duration = seconds;
  options.fps = 10.0;
  options.camera = SmallCamera();
  options.sensor.noise = simulate::SensorNoise::kKinect;
  return simulate::SimulateRoom(options);
}

struct RoomRun {
  int true_loops = 0, false_loops = 0, rejected = 0, lost = 0;
  double first_loop_s = -1.0;  // after the return to the start of the path
  double worst_chi2 = 0.0;
  double rmse = 0.0, path = 0.0;
  std::vector<double> seconds;
};

bool IsTrue(const LoopReport& report, const Map& map, const simulate::Simulation& room) {
  const LoopEdge& edge = report.loop.edge;
  const KeyFrame* match = map.keyframe(edge.match);
  const KeyFrame* keyframe = map.keyframe(edge.keyframe);
  if (match == nullptr || keyframe == nullptr) return true;  // culled since
  const Pose truth = room.T_WC(match->frame.stamp).Inverse() * room.T_WC(keyframe->frame.stamp);
  const Pose error = truth.Inverse() * edge.Z;
  return error.p().norm() < 0.1 && error.Angle() < 0.05;
}

double RmseOf(const Trajectory& truth, const Trajectory& estimate) {
  try {
    return AbsolutePoseError(truth, estimate).statistics.rmse;
  } catch (const InvalidArgument&) {  // too few poses
    return -1.0;
  }
}

RoomRun RunRoom(const simulate::Simulation& room, bool loops) {
  SlamOptions options;
  options.loops.enabled = loops;
  options.loops.background = false;
  SlamSystem slam({.camera = SmallCamera()}, options);
  RoomRun run;
  Trajectory truth;
  const double lap = room.options().duration / 2.0;
  for (int i = 0; i < room.size(); ++i) {
    const auto frame = room.Render(i);
    truth.push_back({frame.stamp, frame.T_WC});
    if (i > 0) run.path += (frame.T_WC.p() - truth[truth.size() - 2].pose.p()).norm();
    const FrameResult result = slam.Track({frame.stamp, frame.bgr, frame.depth});
    if (result.state != TrackingState::kTracking) ++run.lost;
    for (const LoopReport& report : result.loops) {
      if (report.bundle) {
        run.seconds.push_back(report.seconds);
        continue;
      }
      if (!report.accepted) {
        ++run.rejected;
        continue;
      }
      ++(IsTrue(report, slam.map(), room) ? run.true_loops : run.false_loops);
      run.worst_chi2 = std::max(run.worst_chi2, report.loop.chi2);
      const double at = i / room.options().fps - lap;
      if (run.first_loop_s < 0.0) run.first_loop_s = at;
    }
  }
  slam.Finish();
  run.rmse = RmseOf(truth, slam.trajectory());
  return run;
}

}  // namespace

nlohmann::json BenchRooms(int seeds, double seconds) {
  nlohmann::json report;
  int found = 0, false_loops = 0;
  double worst_share = 0.0;
  for (int seed = 1; seed <= seeds; ++seed) {
    const simulate::Simulation room = MakeRoom(seed, seconds);
    const RoomRun without = RunRoom(room, false), with = RunRoom(room, true);
    found += with.true_loops > 0 ? 1 : 0;
    false_loops += with.false_loops;
    worst_share = std::max(worst_share, with.rmse / with.path);
    fmt::print(stderr,
               "room {:>2}: {} true, {} false, {} refused loops, first {:.1f} s after the return, "
               "chi2 up to {:.1f}, "
               "{} lost; APE {:.4f} m, {:.4f} m without loops, path {:.1f} m\n",
               seed, with.true_loops, with.false_loops, with.rejected, with.first_loop_s,
               with.worst_chi2, with.lost, with.rmse, without.rmse, with.path);
    report["runs"].push_back({{"seed", seed},
                              {"true_loops", with.true_loops},
                              {"false_loops", with.false_loops},
                              {"ape_rmse_m", with.rmse},
                              {"ape_rmse_without_m", without.rmse},
                              {"path_m", with.path}});
  }
  report["recall"] = static_cast<double>(found) / seeds;
  report["false_loops"] = false_loops;
  report["worst_ape_over_path"] = worst_share;
  return report;
}

nlohmann::json BenchKidnapped(int seeds) {
  constexpr int kBefore = 160, kBlind = 5;
  nlohmann::json report;
  int found = 0;
  for (int seed = 1; seed <= seeds; ++seed) {
    const simulate::Simulation room = MakeRoom(seed, 20.0);
    SlamSystem slam({.camera = SmallCamera()});
    for (int i = 0; i < kBefore; ++i) {
      const auto frame = room.Render(i);
      slam.Track({frame.stamp, frame.bgr, frame.depth});
    }
    slam.Finish();
    Stamp stamp = room.StampOf(kBefore);
    const cv::Mat blank(240, 320, CV_8UC3, cv::Scalar::all(128));
    const cv::Mat flat(240, 320, CV_32FC1, 2.0F);
    for (int i = 0; i < kBlind; ++i) slam.Track({stamp += 100'000'000, blank, flat});
    // On the way again, half the way round from where it went blind.
    int needed = -1;
    double error = 0.0;
    for (int i = 0; i < 10 && needed < 0; ++i) {
      const auto frame = room.Render(kBefore / 2 + i);
      const FrameResult result = slam.Track({stamp += 100'000'000, frame.bgr, frame.depth});
      if (result.state != TrackingState::kTracking) continue;
      needed = i + 1;
      // In the frame of the first camera, as the map is.
      const Pose truth = room.T_WC(room.StampOf(0)).Inverse() * frame.T_WC;
      const Pose estimate = slam.trajectory().front().pose.Inverse() * result.T_WC;
      error = (truth.p() - estimate.p()).norm();
    }
    const bool good = needed > 0 && error < 0.1;
    found += good ? 1 : 0;
    fmt::print(stderr, "kidnapped {:>2}: {} frames, {:.3f} m off\n", seed, needed, error);
  }
  report["relocalized"] = found;
  report["seeds"] = seeds;
  return report;
}

}  // namespace highwall::bench
