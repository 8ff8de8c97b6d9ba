#pragma once

#include <Eigen/Core>

namespace [[gnu::visibility("default")]] highwall {
namespace internal {

// Eigen's alignment, and with it the layout of every struct that holds a fixed-size matrix, depends
// on the instruction set that a translation unit is compiled for. Core defines this symbol for the
// alignment of its own build, and every user of a core header refers to the symbol for the
// alignment of its own flags: a mismatch is an undefined reference to
// EigenAlignment<32>::kSameAsCore at link time instead of a crash at run time. Build both with the
// same flags.
template <int kMaxAlignBytes>
struct EigenAlignment {
  static const int kSameAsCore;
};
template <>
const int EigenAlignment<EIGEN_MAX_ALIGN_BYTES>::kSameAsCore;

[[gnu::used]] static const int* const eigen_alignment_guard =
    &EigenAlignment<EIGEN_MAX_ALIGN_BYTES>::kSameAsCore;

}  // namespace internal
}  // namespace highwall
