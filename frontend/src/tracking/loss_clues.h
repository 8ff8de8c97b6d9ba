#pragma once

#include <highwall/frontend/features/frame.h>
#include <highwall/frontend/pose/pose_report.h>

namespace highwall {

// What the search for a frame's pose has come to, where it found none.
struct LossClues {
  int tried = 0;           // support (points plus twice the lines) of matches with the last frame
  int agreed = 0;          // of those that agree on a pose
  double set_aside = 0.0;  // share of the features that are on what moves
  double shift = 0.0;      // [px] of the image since the last frame, at constant velocity
  bool predicted = false;  // by an IMU
};

// What is asked of an image.
struct FeatureNeeds {
  int min_features = 0;          // support with depth that can start a map
  double min_corner = 0.0;       // [grey levels] the least contrast of a corner
  double usual_sharpness = 0.0;  // of frames with a pose; 0: not known
  double searched = 0.0;         // [px] about where a landmark is expected
};

// Why a frame without a pose has none: what the image lacks, or else what its matches tell.
LossReason ReasonOf(const FrameFeatures& features, const LossClues& clues,
                    const FeatureNeeds& needs);

}  // namespace highwall
