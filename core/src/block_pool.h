#pragma once

#include <cstddef>
#include <memory>
#include <unordered_map>
#include <vector>

namespace highwall::internal {

// Memory of the blocks of variables. Blocks never move, and returned ones are taken again: Ceres
// 2.1 stores every address that was ever added to a problem, so that new addresses would let its
// memory grow. Blocks of one size are next to each other, because a map has thousands of them.
class BlockPool {
 public:
  // Returns a block of `size` doubles, whose values are not specified.
  double* Take(std::size_t size) {
    std::vector<double*>& spare = spare_[size];
    if (spare.empty()) {
      chunks_.push_back(std::make_unique<double[]>(kBlocks * size));
      for (std::size_t i = kBlocks; i-- > 0;) spare.push_back(chunks_.back().get() + i * size);
    }
    double* const block = spare.back();
    spare.pop_back();
    return block;
  }
  void Return(double* block, std::size_t size) { spare_[size].push_back(block); }

 private:
  static constexpr std::size_t kBlocks = 64;  // of a chunk

  std::vector<std::unique_ptr<double[]>> chunks_;
  std::unordered_map<std::size_t, std::vector<double*>> spare_;  // by size
};

}  // namespace highwall::internal
