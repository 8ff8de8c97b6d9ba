#pragma once

#include <utility>
#include <vector>

#include <highwall/core/pose.h>
#include <highwall/frontend/features/frame.h>
#include <highwall/frontend/map/measurement_model.h>

namespace highwall {

// A frame's features and which of them look for a partner, one flag each.
struct EpipolarView {
  const FrameFeatures& features;
  const Pose& T_WC;
  const std::vector<bool>& wanted;
};

// [m] between two views, below which they have no epipolar lines.
inline constexpr double kNoBaseline = 1e-6;

struct EpipolarMatchOptions {
  int max_hamming = 50;  // [bit] of a pair
  double ratio = 0.8;    // (0, 1]: best against second best on the line
  double chi2 = 3.841;   // > 0: of the distance from the line
};

// Pairs (feature of a, feature of b) of corners that may be one point whose distance nobody knows:
// alike, of neighbouring levels, and b's on the line on which all points along a's ray are seen,
// where no other comes near in likeness. Of several of a that take the same one of b the most alike
// has it. Empty where the two cameras are at one place.
std::vector<std::pair<int, int>> MatchEpipolar(const MeasurementModel& model, const EpipolarView& a,
                                               const EpipolarView& b,
                                               const EpipolarMatchOptions& options);

}  // namespace highwall
