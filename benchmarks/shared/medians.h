#pragma once

#include <map>
#include <string>
#include <vector>

namespace highwall::bench {

// What one run is worth; by name, in the unit that the name ends with. A figure that could not be
// computed is absent.
using Scores = std::map<std::string, double>;

// Of each figure over the runs that have it.
Scores Medians(const std::vector<Scores>& runs);

}  // namespace highwall::bench
