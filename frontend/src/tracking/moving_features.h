#pragma once

#include <opencv2/core/mat.hpp>

#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/measurement_model.h>
#include <highwall/frontend/tracking/options.h>

#include "features/depth_grid.h"
#include "tracking/moving_objects.h"
#include "tracking/tracked_frame.h"

namespace highwall {

// Which features of a frame lie on what moves, by the depth of the last seconds and by the
// landmarks that it was matched with.
class MovingFeatures {
 public:
  // model: must outlive it. pose: how a pose is found from the landmarks that are not judged.
  MovingFeatures(const MeasurementModel& model, const MovingObjectOptions& options,
                 const PoseSolverOptions& pose);

  const DepthGrid& grid() const { return objects_.grid(); }
  MovingObjects& objects() { return objects_; }
  const MovingObjects& objects() const { return objects_; }

  // What moves in a frame, seen from its pose (TrackedFrame::moving).
  cv::Mat Find(const TrackedFrame& tracked, const Map& map) const;
  // Takes the features off a frame that are on what moves in it.
  void SetAside(TrackedFrame& rough) const;
  // Of the landmarks that are not on `moving`.
  int SupportBeside(const TrackedFrame& tracked, const cv::Mat& moving) const;

 private:
  // Whether the landmarks on a surface of the depth grid contradict all others but those on
  // `moving`.
  bool HasMoved(const TrackedFrame& rough, const Map& map, const DepthSurfaces& surfaces,
                int surface, const cv::Mat& moving) const;

  const MeasurementModel& model_;
  MovingObjectOptions options_;
  PoseSolverOptions pose_;
  MovingObjects objects_;
};

}  // namespace highwall
