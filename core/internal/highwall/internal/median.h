#pragma once

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

namespace [[gnu::visibility("default")]] highwall {

// Returns the median, for an even number the upper of the two middle values; needs at least one
// value.
template <class T>
T UpperMedian(std::vector<T> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace highwall
