#pragma once

#include <cstddef>

#include "pose/support.h"
#include "tracking/landmark_observations.h"
#include "tracking/tracked_frame.h"

namespace highwall {

// A frame matched with the local map, and the landmarks predicted to be visible from its pose.
struct LocalMatch {
  TrackedFrame frame;
  PerKind<LandmarkIds> in_view{};

  int Support() const { return highwall::Support(frame.num_points, frame.num_lines); }
  std::size_t SupportInView() const { return SupportOf(in_view); }
};

}  // namespace highwall
