#pragma once

#include <cstddef>
#include <memory>
#include <optional>

#include <highwall/core/camera.h>
#include <highwall/factors/depth_pattern.h>
#include <highwall/frontend/local/options.h>
#include <highwall/frontend/loops/options.h>
#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/measurement_model.h>
#include <highwall/internal/background_job.h>

namespace highwall {

// Finds out by how much depth is off from place to place in the image, from a map while it grows
// (CalibrateCamera), and what that map is once it is mended: features of keyframes, and all of its
// world adjusted to them.                                docs/calibration.md, While tracking
class DepthPatternFinder {
 public:
  // camera: with its distortion. bundle: of the adjustment of a mended map.
  DepthPatternFinder(const PinholeCamera& camera, const DepthPatternOptions& options,
                     const BundleAdjustmentOptions& bundle);
  // Work that has not ended is waited for.
  ~DepthPatternFinder();
  DepthPatternFinder(const DepthPatternFinder&) = delete;
  DepthPatternFinder& operator=(const DepthPatternFinder&) = delete;

  // What the depth of images is to be mended by from now on.
  const DepthPattern& pattern() const { return pattern_; }

  // Begins where the world of the submap has grown by enough since the last time and nothing is
  // under way. given: keyframes up to this one came with the map, mended or not.
  void Begin(const Map& map, const MeasurementModel& model, SubmapId submap, KeyFrameId given);
  // Was anything found that is ready to be applied?
  bool HasResult() const;
  // Waits for the work to end and applies it to the map, between frames: where a pattern was found,
  // keyframes of this run are mended and those of the world are where the adjustment has them.
  // Whether that was so. Throws what ended the work.
  bool Finish(Map* map);
  // Nothing of what is being worked on is applied: the map was moved under it. Does not wait.
  void Cancel();

 private:
  class Job;

  const PinholeCamera camera_;
  const DepthPatternOptions options_;
  const BundleAdjustmentOptions bundle_;
  DepthPattern pattern_;
  std::optional<double> sigma_;  // [1/m] RMS of the deviations of a pattern that was found
  std::size_t next_;             // keyframes of a world
  JobSlot<Job> job_;
};

}  // namespace highwall
