#pragma once

#include <memory>
#include <span>
#include <stop_token>
#include <utility>
#include <vector>

#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/measurement_model.h>

namespace highwall {

struct BundleAdjustmentOptions {
  double point_huber = 2.8;   // [sigma] > 0: Huber threshold on the norm of a point's rows
  double line_huber = 2.8;    // [sigma] > 0: the same for a line's rows
  double chi2_2 = 5.991;      // > 0: inlier bounds, 95 % of chi-square with 2, 3 and 4 rows
  double chi2_3 = 7.815;      // > 0
  double chi2_4 = 9.488;      // > 0
  int first_iterations = 5;   // >= 1: with all observations
  int second_iterations = 8;  // >= 1: without outliers
  double tolerance = 1e-6;    // >= 0: ends before, where a step lowers the cost by a smaller share
  // > 0: of the first step, as SolveOptions::initial_trust_region_radius. Small, it holds what is
  // measured badly where it was; large, it lets a few steps straighten the bend of a long loop,
  // which costs next to nothing. Of lines alone none larger than 1e4 is taken.
  double trust_region = 1e4;
  int threads = 2;  // >= 1; with more than one the last bits vary from run to run

  void Validate() const;
};

struct BundleAdjustmentReport {
  int keyframes = 0, fixed_keyframes = 0, points = 0, lines = 0;
  int observations = 0, outliers = 0;
  int imu_factors = 0;
  double initial_cost = 0.0, final_cost = 0.0;
  bool usable = false;  // false: the solver failed and the map was not touched
};

// Sights of landmarks that an adjustment found wrong.
struct OutlierSights {
  std::vector<std::pair<KeyFrameId, PointId>> points;
  std::vector<std::pair<KeyFrameId, LineId>> lines;
};

// The keyframes see them no more; what is no more is passed over.
void Forget(const OutlierSights& outliers, Map* map);

// Moves the keyframes of `free` and every point and line that they see, so that the reprojection
// errors of `free` and `fixed` are least; observations that remain outliers are forgotten. Lines
// move in the orthonormal form and keep their ends where they were seen. Where the map knows
// gravity, the IMU between keyframes takes part, with their velocities and biases as unknowns.
//
// In three steps, so that the map may go on while another thread solves: the constructor copies
// what takes part, Solve() knows no map, Write() brings the result back.
class BundleAdjuster {
 public:
  // free, fixed: live, no keyframe in both; where `fixed` is empty the oldest of `free` is held.
  // model: must outlive the adjuster. Throws InvalidArgument on bad options.
  BundleAdjuster(const Map& map, const MeasurementModel& model, std::span<const KeyFrameId> free,
                 std::span<const KeyFrameId> fixed, const BundleAdjustmentOptions& options = {});
  ~BundleAdjuster();
  BundleAdjuster(const BundleAdjuster&) = delete;
  BundleAdjuster& operator=(const BundleAdjuster&) = delete;

  // Once, before Write(). Where a stop is requested it ends after the running iteration, with what
  // was reached; stopped before the first iterations are done it finds no outliers.
  void Solve(const std::stop_token& stop = {});
  // The map: as it was, and nothing of it moved since; it may have grown, and what has left it is
  // passed over. A solve that failed leaves it untouched.
  BundleAdjustmentReport Write(Map* map) const;
  // After Solve(): what Write() forgets.
  const OutlierSights& outliers() const;

 private:
  struct Result;
  class Problem;

  std::unique_ptr<Problem> problem_;      // until it is solved
  std::unique_ptr<const Result> result_;  // from then on
};

// All three steps.
BundleAdjustmentReport AdjustBundle(Map& map, const MeasurementModel& model,
                                    std::span<const KeyFrameId> free,
                                    std::span<const KeyFrameId> fixed,
                                    const BundleAdjustmentOptions& options = {},
                                    const std::stop_token& stop = {});

}  // namespace highwall
