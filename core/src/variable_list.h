#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include <highwall/core/variable.h>

namespace highwall::internal {

// The variables of a factor. Most factors have two: up to three need no memory from the heap.
class VariableList {
 public:
  void Assign(std::span<const VariableId> variables) {
    size_ = variables.size();
    if (size_ <= few_.size()) {
      std::ranges::copy(variables, few_.begin());
    } else {
      many_.assign(variables.begin(), variables.end());
    }
  }
  void Clear() {
    size_ = 0;
    many_ = {};
  }

  std::size_t size() const { return size_; }
  const VariableId* begin() const { return size_ <= few_.size() ? few_.data() : many_.data(); }
  const VariableId* end() const { return begin() + size_; }
  const VariableId& operator[](std::size_t i) const { return begin()[i]; }

 private:
  std::size_t size_ = 0;
  std::array<VariableId, 3> few_;
  std::vector<VariableId> many_;  // all of them, if they are more
};

}  // namespace highwall::internal
