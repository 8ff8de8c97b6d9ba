#pragma once

#include <memory>
#include <span>
#include <stop_token>

#include <highwall/frontend/local/options.h>
#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/map_report.h>
#include <highwall/frontend/map/measurement_model.h>
#include <highwall/frontend/map/outlier_observations.h>

namespace [[gnu::visibility("default")]] highwall {

// Minimizes the reprojection errors of `free` and `fixed` over the keyframes of `free` and every
// point and line that they observe, and removes the observations that remain outliers. Lines use
// the orthonormal form and keep their ends where they were observed. A point that only one of
// the keyframes observes constrains nothing and keeps its place relative to that one. If the map
// knows gravity, the IMU between keyframes takes part, with their velocities and biases as
// unknowns, which are written to the map, and gravity's direction, which is written if `fixed` is
// empty; so do the user factors (FactorsIn) on these keyframes, and KeyFrame::image_motion.
//
// In three steps, so that the map may be used while another thread solves: the constructor copies
// the inputs, Solve() does not access the map, Write() writes the result to it.
class BundleAdjuster {
 public:
  // free, fixed: active keyframes, none in both; if `fixed` is empty the oldest of `free` is held.
  // model: must outlive the adjuster. threads: >= 1, of the solver where more than 66 keyframes
  // move; with more than one the last bits vary from run to run then. Throws InvalidArgument on bad
  // options.
  BundleAdjuster(const Map& map, const MeasurementModel& model, std::span<const KeyFrameId> free,
                 std::span<const KeyFrameId> fixed, const BundleAdjustmentOptions& options = {},
                 int threads = 1);
  ~BundleAdjuster();
  BundleAdjuster(const BundleAdjuster&) = delete;
  BundleAdjuster& operator=(const BundleAdjuster&) = delete;

  // To be called once, before Write(). On a stop request it ends after the current iteration with
  // the result so far; if stopped before the first iterations are done it removes no outliers.
  void Solve(const std::stop_token& stop = {});
  // map: the same one, with no part of it moved since; it may have grown, and elements removed from
  // it are skipped. A failed solve leaves it unchanged.
  BundleAdjustmentReport Write(Map* map) const;
  // Returns the outliers that Write() removes. To be called after Solve().
  const OutlierObservations& outliers() const;

 private:
  struct Result;
  class Problem;

  std::unique_ptr<Problem> problem_;      // until Solve()
  std::unique_ptr<const Result> result_;  // after Solve()
};

// Runs all three steps.
BundleAdjustmentReport AdjustBundle(Map& map, const MeasurementModel& model,
                                    std::span<const KeyFrameId> free,
                                    std::span<const KeyFrameId> fixed,
                                    const BundleAdjustmentOptions& options = {},
                                    const std::stop_token& stop = {}, int threads = 1);

}  // namespace highwall
