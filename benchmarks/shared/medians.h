#pragma once

#include <map>
#include <string>
#include <vector>

namespace highwall::bench {

// Figures of one run, by name, in the unit at the end of the name. A figure that could not be
// computed is absent.
using Scores = std::map<std::string, double>;

// Returns the median of each figure over the runs that have it.
Scores Medians(const std::vector<Scores>& runs);

}  // namespace highwall::bench
