#pragma once

#include <highwall/core/stamp.h>
#include <highwall/factors/depth_pattern.h>
#include <highwall/frontend/features/frame.h>

#include "features/row_times.h"

namespace highwall {

// A frame that has no pose, or that has lost it with its submap.
struct LostFrame {
  Frame frame{};
  Stamp stamp = 0;                 // of its image: `frame` is of the time at which colour was taken
  RowMotion moved_by{};            // by which its rows were compensated
  DepthPattern pattern{};          // depth distortion that its depth was corrected by
  double usual_match_ratio = 0.0;  // mean match ratio of the frames at that time; 0: unknown
};

}  // namespace highwall
