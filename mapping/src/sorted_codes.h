#pragma once

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <vector>

namespace highwall::internal {

// Set of bricks or blocks: ascending codes, each once.
using Codes = std::vector<std::uint64_t>;

inline Codes Union(const Codes& a, const Codes& b) {
  Codes result;
  result.reserve(a.size() + b.size());
  std::ranges::set_union(a, b, std::back_inserter(result));
  return result;
}

inline bool Intersect(const Codes& a, const Codes& b) {
  for (auto i = a.begin(), j = b.begin(); i != a.end() && j != b.end();) {
    if (*i == *j) return true;
    *i < *j ? ++i : ++j;
  }
  return false;
}

}  // namespace highwall::internal
