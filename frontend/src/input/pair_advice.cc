#include "input/pair_advice.h"

#include <algorithm>
#include <cmath>

#include <highwall/core/stamp.h>
#include <highwall/internal/number_text.h>

namespace highwall {
namespace {

std::string ThreeDigits(double value) {
  return RoundedText(value, 3);
}

// Returns the stamps of the images that are in no pair.
std::vector<Stamp> StampsAlone(const std::vector<TumImageFile>& files,
                               std::vector<std::size_t> paired) {
  std::ranges::sort(paired);
  std::vector<Stamp> stamps;
  for (std::size_t i = 0; i < files.size(); ++i) {
    if (!std::ranges::binary_search(paired, i)) stamps.push_back(files[i].stamp);
  }
  return stamps;
}

// Returns [s] from each stamp to the nearest of the others, ascending; others: sorted, not empty.
std::vector<double> OffsetsToNearest(const std::vector<Stamp>& stamps,
                                     const std::vector<Stamp>& others) {
  std::vector<double> offsets;
  for (const Stamp stamp : stamps) {
    auto nearest = std::ranges::lower_bound(others, stamp);
    if (nearest == others.end() ||
        (nearest != others.begin() && stamp - *std::prev(nearest) < *nearest - stamp)) {
      --nearest;
    }
    offsets.push_back(ToSeconds(*nearest - stamp));
  }
  std::ranges::sort(offsets);
  return offsets;
}

}  // namespace

std::string AdviceOnPairs(const std::vector<TumImageFile>& colour,
                          const std::vector<TumImageFile>& depth,
                          const std::vector<std::pair<std::size_t, std::size_t>>& pairs) {
  std::vector<std::size_t> first, second;
  for (const auto& [i, j] : pairs) {
    first.push_back(i);
    second.push_back(j);
  }
  const std::vector<Stamp> colour_alone = StampsAlone(colour, std::move(first));
  const std::vector<Stamp> depth_alone = StampsAlone(depth, std::move(second));
  const bool missing = !pairs.empty() && 2 * depth_alone.size() < colour_alone.size();
  if (missing || colour_alone.empty() || depth_alone.empty()) return "";
  const std::vector<double> offsets = OffsetsToNearest(colour_alone, depth_alone);
  const double median = offsets[offsets.size() / 2];
  std::string advice = ": depth is " + ThreeDigits(std::abs(median)) + " s " +
                       (median > 0.0 ? "later" : "earlier") + " in the median; ";
  // [s]; a larger median indicates different clocks, not exposures
  constexpr double kOneClock = 0.5;
  if (std::abs(median) > kOneClock) return advice + "write both lists in one clock";
  // Limit that nine of ten pairs keep, rounded up.
  constexpr double kStep = 0.005;  // [s]
  const std::size_t tenth = offsets.size() / 10;
  const double most =
      std::max(std::abs(offsets[tenth]), std::abs(offsets[offsets.size() - 1 - tenth]));
  return advice + "give --max-pair-difference " +
         ThreeDigits(kStep * (std::floor(most / kStep + 1e-6) + 1.0));
}

}  // namespace highwall
