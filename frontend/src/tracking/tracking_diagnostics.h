#pragma once

#include <optional>

#include <highwall/frontend/features/frame.h>
#include <highwall/frontend/pose/pose_report.h>

namespace highwall {

// Diagnostics of one attempt at a pose.
struct AttemptDiagnostics {
  int tried = 0, agreed = 0;           // as in TrackingDiagnostics
  std::optional<double> masked_share;  // empty: no matches were tested
  std::optional<double> shift;         // empty: an IMU predicts the motion
};

// Tracking diagnostics of a frame without a pose.
struct TrackingDiagnostics {
  int tried = 0;   // support (points plus twice the lines) of matches with the last frame
  int agreed = 0;  // support of those consistent with one pose
  double masked_share = 0.0;  // share of the features masked out on dynamic objects
  double shift = 0.0;         // [px] image shift since the last frame, at constant velocity
  bool predicted = false;     // by an IMU

  // Adds an attempt after the others.
  void Add(const AttemptDiagnostics& attempt);
};

// Requirements on an image.
struct FeatureNeeds {
  int min_features = 0;          // support with depth that can start a map
  double min_corner = 0.0;       // [grey levels] minimum contrast of a corner
  double usual_sharpness = 0.0;  // of frames with a pose; 0: unknown
  double searched = 0.0;         // [px] image shift that the search can follow at most
};

// Returns why the pose of a frame was not found: because of the image, or else because of its
// matches.
LossReason ReasonOf(const FrameFeatures& features, const TrackingDiagnostics& diagnostics,
                    const FeatureNeeds& needs);

}  // namespace highwall
