#include <highwall/core/abi.h>

namespace highwall::internal {

template <>
const int EigenAlignment<EIGEN_MAX_ALIGN_BYTES>::kSameAsCore = EIGEN_MAX_ALIGN_BYTES;

}  // namespace highwall::internal
