#pragma once

#include <utility>
#include <vector>

#include "map/epipolar_matcher.h"

namespace highwall {

// Returns pairs (segment of a, segment of b) that may be one line of unknown depth: similar by
// model.matching().lines, and for some depth in front of a's camera each end of a's segment
// lies on b's line, so that the observed parts overlap, with the brighter side on the same side,
// and the match is unambiguous. Of several segments of a with the same partner the most similar is
// kept. Lines along which, or in whose plane, the camera moved are skipped: their depth is
// unobservable. Empty if the two cameras are at the same position or segments have no descriptors.
std::vector<std::pair<int, int>> MatchEpipolarLines(const MeasurementModel& model,
                                                    const EpipolarView& a, const EpipolarView& b,
                                                    double chi2);

}  // namespace highwall
