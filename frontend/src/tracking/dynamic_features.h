#pragma once

#include <opencv2/core/mat.hpp>

#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/measurement_model.h>
#include <highwall/frontend/tracking/options.h>

#include "features/depth_grid.h"
#include "tracking/dynamic_objects.h"
#include "tracking/tracked_frame.h"

namespace highwall {

// Classifies features of a frame as dynamic, by the depth of the last seconds and by the landmarks
// that it was matched with.
class DynamicFeatures {
 public:
  // model: must outlive it.
  DynamicFeatures(const MeasurementModel& model, const DynamicObjectOptions& options,
                  const DynamicObjectParameters& parameters = {});

  const DepthGrid& grid() const { return objects_.grid(); }
  DynamicObjects& objects() { return objects_; }
  const DynamicObjects& objects() const { return objects_; }

  // Returns the dynamic mask of a frame at its pose (TrackedFrame::moving).
  cv::Mat Find(const TrackedFrame& tracked, const Map& map) const;
  // Removes the features on dynamic objects from a frame.
  void MaskOut(TrackedFrame& rough) const;
  // Returns the support of the landmarks outside `moving`.
  int SupportBeside(const TrackedFrame& tracked, const cv::Mat& moving) const;

 private:
  // Returns whether the landmarks on a surface of the depth grid are inconsistent with all others
  // outside `moving`.
  bool HasMoved(const TrackedFrame& rough, const Map& map, const DepthSurfaces& surfaces,
                int surface, const cv::Mat& moving) const;

  const MeasurementModel& model_;
  LandmarkMotionOptions landmarks_;
  DynamicObjects objects_;
};

}  // namespace highwall
