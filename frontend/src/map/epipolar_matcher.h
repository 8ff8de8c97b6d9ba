#pragma once

#include <utility>
#include <vector>

#include <highwall/core/pose.h>
#include <highwall/frontend/features/frame.h>
#include <highwall/frontend/map/measurement_model.h>

namespace highwall {

// A frame's features and flags of those to be matched.
struct EpipolarView {
  const FrameFeatures& features;
  const Pose& T_WC;
  const std::vector<bool>& wanted;
};

// [m] baseline below which two views have no epipolar geometry.
inline constexpr double kNoBaseline = 1e-6;

struct EpipolarMatchOptions {
  int max_hamming = 50;  // [bit] of a pair
  double ratio = 0.8;    // (0, 1]: best against second best on the line
  double chi2 = 3.841;   // > 0: of the distance from the line
};

// Returns pairs (feature of a, feature of b) of corners that may be one point of unknown depth:
// similar, of neighbouring levels, b's on the epipolar line of a's, and unambiguous. Of several
// corners of a with the same partner the most similar is kept. Empty if the two cameras are at the
// same position.
std::vector<std::pair<int, int>> MatchEpipolar(const MeasurementModel& model, const EpipolarView& a,
                                               const EpipolarView& b,
                                               const EpipolarMatchOptions& options);

}  // namespace highwall
