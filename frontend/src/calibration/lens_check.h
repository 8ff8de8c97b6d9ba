#pragma once

#include <cstddef>
#include <optional>

#include <highwall/frontend/input/sensor_verdict.h>
#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/measurement_model.h>

#include "calibration/lens_estimate.h"

namespace highwall {

// Largest standard deviations of values that images constrain, relative to the focal length.
struct LensSigmas {
  double focal = 0.0, centre = 0.0;
};

// Returns the estimate with the known values in the place of what the images hardly constrain:
// where the scatter is large, the errors that groups share are as well.
LensEstimate Constrained(LensEstimate estimate, const PinholeCamera& camera,
                         const LensSigmas& most);

// Returns a finding if the lens of the model differs from the estimate significantly, by more than
// calibrations of one camera do, and if the images show the difference (docs/misconfiguration.md,
// Lens). If the estimate is of no lens, one focal length longer and the other shorter than stated
// and pixels less square, only a clear distortion is a finding. The text is about the value whose
// deviation the images show most.
std::optional<SensorFinding> CompareLens(const PinholeCamera& camera, const LensEstimate& estimate);

// Returns a finding if the principal point is stated far from the middle of the image, where it
// hardly ever is, and the estimate is significantly nearer to the middle. least_growth: of the
// squared residuals with the stated value, relative.
std::optional<SensorFinding> CheckFarCentre(const PinholeCamera& camera,
                                            const LensEstimate& estimate,
                                            double least_growth = 0.0015);

// Returns a finding if the principal point is stated 15 % of a side or more from the middle of the
// image, which only cropped images have, unless the estimate confirms it.
std::optional<SensorFinding> CheckUnusualCentre(const PinholeCamera& camera,
                                                const std::optional<LensEstimate>& estimate);

// Returns a finding if cx and cy are exchanged: as stated they are far from the middle of the image
// in both directions, and the other way round they are near it. Without images.
std::optional<SensorFinding> CheckExchangedCentre(const PinholeCamera& camera);

// Tests the lens of a run by the map: EstimateLens() of its newest keyframes each time that it has
// twice as many as the last time, and at its end. Only reads the map.
class LensCheck {
 public:
  // Call after a new keyframe. given: keyframes up to this one came with the map.
  std::optional<SensorFinding> Update(const Map& map, const MeasurementModel& model,
                                      SubmapId submap, KeyFrameId given);
  // Call at the end; empty if no keyframe was made since the last test.
  std::optional<SensorFinding> Finish(const Map& map, const MeasurementModel& model,
                                      SubmapId submap, KeyFrameId given);

 private:
  std::size_t next_ = 24;   // keyframes at the next test
  std::size_t tested_ = 0;  // keyframes at the last one
};

}  // namespace highwall
