#pragma once

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

namespace [[gnu::visibility("default")]] highwall {

// The middle one of the values, the upper of two where their number is even; at least one value.
template <class T>
T UpperMedian(std::vector<T> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace highwall
