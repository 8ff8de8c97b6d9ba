#pragma once

#include <memory>
#include <span>
#include <stop_token>
#include <utility>
#include <vector>

#include <highwall/frontend/local/options.h>
#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/map_report.h>
#include <highwall/frontend/map/measurement_model.h>

namespace highwall {

// Observations of landmarks that an adjustment found wrong.
struct OutlierObservations {
  std::vector<std::pair<KeyFrameId, PointId>> points;
  std::vector<std::pair<KeyFrameId, LineId>> lines;
};

// The keyframes observe them no more; what is no more is passed over.
void Forget(const OutlierObservations& outliers, Map* map);

// Moves the keyframes of `free` and every point and line that they observe, so that the
// reprojection errors of `free` and `fixed` are least; observations that remain outliers are
// forgotten. Lines move in the orthonormal form and keep their ends where they were observed. Where
// the map knows gravity, the IMU between keyframes takes part, with their velocities and biases as
// unknowns, which the map keeps, and gravity's direction, which it keeps where `fixed` is empty;
// and so do the factors of the user's (FactorsIn) on these keyframes.
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
  const OutlierObservations& outliers() const;

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
