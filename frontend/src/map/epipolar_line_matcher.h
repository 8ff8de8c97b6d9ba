#pragma once

#include <utility>
#include <vector>

#include "map/epipolar_matcher.h"

namespace highwall {

// Pairs (segment of a, segment of b) that may be one line whose distance nobody knows: alike, as
// model.options().line_matches says, and some distance before a's camera puts each end of a's
// segment on b's line, so that what both saw of it overlaps, with the brighter side on the same
// side, where no other comes near in likeness. Of several of a that take the same one of b the most
// alike has it. Lines along which, or in whose plane, the camera moved are passed over: any
// distance would do. Empty where the two cameras are at one place or segments have no descriptors.
std::vector<std::pair<int, int>> MatchEpipolarLines(const MeasurementModel& model,
                                                    const EpipolarView& a, const EpipolarView& b,
                                                    double chi2);

}  // namespace highwall
