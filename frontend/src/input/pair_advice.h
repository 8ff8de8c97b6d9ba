#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include <highwall/frontend/input/tum_dataset.h>

namespace highwall {

// Returns advice on the colour and depth images that are in none of the pairs: ": depth is 0.025 s
// later in the median; give --max-pair-difference 0.03", or that the clocks differ. Empty if depth
// images are missing, so that no limit would help. Both lists must be sorted.
std::string AdviceOnPairs(const std::vector<TumImageFile>& colour,
                          const std::vector<TumImageFile>& depth,
                          const std::vector<std::pair<std::size_t, std::size_t>>& pairs);

}  // namespace highwall
