#pragma once

#include <optional>
#include <string>
#include <vector>

#include <highwall/core/trajectory.h>
#include <highwall/frontend/system/slam_system.h>

#include "consistency.h"
#include "generated_sequence.h"
#include "medians.h"
#include "run/slam_run.h"

namespace highwall::bench {

// Interval in which the lens is covered.
inline constexpr const char* kBlackoutSpan = "blackout";

// Records a run frame by frame, then scores it against the ground truth.
class Judge {
 public:
  // sequence: must outlive this. time_offset [s]: the true one.
  Judge(const Sequence& sequence, double time_offset);

  void Watch(const FrameResult& result);
  Scores Score(const apps::SlamRun& run) const;

 private:
  void ScoreTrajectory(const apps::SlamRun& run, Scores* scores) const;
  void ScoreSpans(const apps::SlamRun& run, Scores* scores) const;
  // Returns the drift over the span [% of the distance] of pure integration of the readings from
  // the true state at its first frame; empty if the sequence ends before.
  std::optional<double> ExactStart(const MarkedSpan& span) const;
  void ScoreInertial(const apps::SlamRun& run, Scores* scores) const;
  double Seconds(Stamp stamp) const;  // since the first frame

  const Sequence& sequence_;
  double time_offset_;
  Trajectory truth_;                          // of every frame
  Trajectory causal_;                         // poses at the time of tracking
  Trajectory levelled_;                       // the same in the world after later gravity alignment
  std::vector<NormalizedErrors> normalized_;  // one per frame
  std::optional<ImuBias> bias_sigmas_;        // the last errors, in standard deviations
};

}  // namespace highwall::bench
