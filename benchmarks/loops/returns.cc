#include "bench_loops.h"

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include <highwall/core/error.h>
#include <highwall/core/trajectory_error.h>
#include <highwall/frontend/system/slam_system.h>

#include "scenes.h"

namespace highwall::bench {
namespace {

// [s] for one lap outdoors and the additional time that a loop needs.
double OnceRound(const std::string& scene) {
  return scene == "mine" ? 95.0 : 85.0;
}

bool IsTrue(const LoopReport& report, const Map& map, const simulate::Simulation& scene) {
  const LoopEdge& edge = report.loop.edge;
  const KeyFrame* match = map.keyframe(edge.match);
  const KeyFrame* keyframe = map.keyframe(edge.keyframe);
  if (match == nullptr || keyframe == nullptr) return true;  // culled since then
  const Pose truth = scene.T_WC(match->frame.stamp).Inverse() * scene.T_WC(keyframe->frame.stamp);
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

// One system on its path through a scene.
class ReturnWalk {
 public:
  ReturnWalk(const simulate::Simulation& scene, bool loops, bool imu) : scene_(scene) {
    SlamOptions options = Deterministic({});
    options.loops.enabled = loops;
    std::optional<ImuCalibration> calibration;
    if (imu) {
      calibration = CalibrationOf(scene.options().imu);
      readings_ = scene.ImuSamples();
    }
    slam_ = std::make_unique<SlamSystem>(RgbdSensor{.camera = scene.options().camera}, options,
                                         SlamInputs{.imu = calibration});
  }

  void Track(const simulate::SimulatedFrame& frame, double time) {
    for (; next_ < readings_.size() && readings_[next_].stamp <= frame.stamp + 100'000'000;
         ++next_) {
      slam_->AddImu(readings_[next_]);
    }
    const FrameResult result = slam_->Track({frame.stamp, frame.bgr, frame.depth});
    if (!HasPose(result.state)) ++lost;
    for (const LoopReport& report : result.loops) {
      if (report.bundle) continue;  // of a loop already counted
      if (!report.accepted) {
        ++refused;
        continue;
      }
      ++(IsTrue(report, slam_->map(), scene_) ? true_loops : false_loops);
      worst_chi2 = std::max(worst_chi2, report.loop.chi2);
      if (!first_loop_s) first_loop_s = time;
    }
  }
  double Rmse(const Trajectory& truth) const { return RmseOf(truth, slam_->trajectory()); }

  int true_loops = 0, false_loops = 0, refused = 0, lost = 0;
  double worst_chi2 = 0.0;
  std::optional<double> first_loop_s;  // since the start of the walk

 private:
  const simulate::Simulation& scene_;
  std::vector<ImuSample> readings_;
  std::size_t next_ = 0;
  std::unique_ptr<SlamSystem> slam_;
};

}  // namespace

nlohmann::json BenchReturns(const std::string& scene, int seeds, double seconds) {
  const bool room = scene == "room";
  nlohmann::json report;
  int found = 0, false_loops = 0;
  double worst_share = 0.0;
  for (int seed = 1; seed <= seeds; ++seed) {
    const simulate::Simulation simulation =
        room ? MakeRoom(seed, seconds)
             : Simulate(scene, SmallFieldTestOptions(seed, OnceRound(scene)));
    ReturnWalk with(simulation, true, !room);
    std::optional<ReturnWalk> without;  // only in rooms: elsewhere it would double the time
    if (room) without.emplace(simulation, false, false);
    Trajectory truth;
    double path = 0.0;
    for (int i = 0; i < simulation.size(); ++i) {
      const auto frame = simulation.Render(i);
      if (i > 0) path += (frame.T_WC.p() - truth.back().pose.p()).norm();
      truth.push_back({frame.stamp, frame.T_WC});
      with.Track(frame, i / simulation.options().fps);
      if (without) without->Track(frame, i / simulation.options().fps);
    }
    const double rmse = with.Rmse(truth);
    found += with.true_loops > 0 ? 1 : 0;
    false_loops += with.false_loops;
    worst_share = std::max(worst_share, rmse / path);
    fmt::print(stderr,
               "{} {:>2}: {} true, {} false, {} refused loops, first after {:.1f} s, chi2 {:.1f}, "
               "{} lost; APE {:.4f} m, path {:.1f} m\n",
               scene, seed, with.true_loops, with.false_loops, with.refused,
               with.first_loop_s.value_or(-1.0), with.worst_chi2, with.lost, rmse, path);
    report["runs"].push_back({{"seed", seed},
                              {"true_loops", with.true_loops},
                              {"false_loops", with.false_loops},
                              {"refused_loops", with.refused},
                              {"lost_frames", with.lost},
                              {"ape_rmse_m", rmse},
                              {"path_m", path}});
    if (without) report["runs"].back()["ape_rmse_without_m"] = without->Rmse(truth);
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
    // Continues half a lap away from where the camera was blinded.
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
