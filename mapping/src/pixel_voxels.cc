#include "pixel_voxels.h"

#include <cmath>
#include <cstddef>
#include <limits>

#include <highwall/internal/target_clones.h>

namespace highwall::internal {
namespace {

// One row of the transformation p_W = R_WC p_C + p_WC.
struct AxisTransform {
  float r_x, r_y, r_z, t;

  // The order of operations affects the result: rounding decides on which side of a border a point
  // lies.
  float operator()(float m_x, float m_y, float z) const {
    return r_x * (m_x * z) + (r_y * (m_y * z) + r_z * z) + t;
  }
};

// Inner loop of a scan over all pixels, free of branches so that it compiles to vector instructions
// (AVX2 without FMA: both clones round identically). Voxels are computed in single precision;
// `unsure` is set where that may give the wrong side of a border.
HIGHWALL_TARGET_CLONES("avx2", "default")
void RowVoxels(const float* __restrict z, const float* __restrict m_x, const float* __restrict m_y,
               int count, float min_depth, const AxisTransform& transform, float inverse_resolution,
               int* __restrict voxels, int* __restrict unsure) {
  const AxisTransform a = transform;
  constexpr float kLimit = kKeyOffset;
  constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
  // Adding this constant leaves no bits for a fraction: rounds to the nearest integer.
  constexpr float kRound = 0x1.8p23f;
  // Rounding errors of the inverse and of the product, 2^-24 each, with a safety factor of two.
  constexpr float kError = 0x1p-22f;
  for (int i = 0; i < count; ++i) {
    const float depth = z[i] >= min_depth ? z[i] : kNone;
    float scaled = (a.r_x * (m_x[i] * depth) + (a.r_y * (m_y[i] * depth) + a.r_z * depth) + a.t) *
                   inverse_resolution;
    scaled = scaled > -kLimit ? scaled : -kLimit;
    scaled = scaled < kLimit ? scaled : kLimit;
    const float rounded = (scaled + kRound) - kRound;
    voxels[i] = static_cast<int>(rounded) - (scaled < rounded ? 1 : 0) + kKeyOffset;
    const float size = std::abs(scaled);
    unsure[i] |= (std::abs(scaled - rounded) <= size * kError ? 1 : 0) & (size < kLimit ? 1 : 0);
  }
}

// Marks changes[i] if pixel i may lie in another voxel than pixel i - 1.
HIGHWALL_TARGET_CLONES("avx2", "default")
void MarkChanges(const int* __restrict x, const int* __restrict y, const int* __restrict z,
                 const int* __restrict unsure, int count, int* __restrict changes) {
  changes[0] = 1;
  for (int i = 1; i < count; ++i) {
    const int difference = (x[i] ^ x[i - 1]) | (y[i] ^ y[i - 1]) | (z[i] ^ z[i - 1]);
    changes[i] = (difference | unsure[i] | unsure[i - 1]) != 0 ? 1 : 0;
  }
}

}  // namespace

const std::vector<VoxelKey>& PixelVoxels::OfRow(const float* z, const float* m_x, const float* m_y,
                                                int count, float min_depth,
                                                const Eigen::Matrix3f& R_WC,
                                                const Eigen::Vector3f& p_WC,
                                                double inverse_resolution) {
  const auto size = static_cast<std::size_t>(count);
  voxels_.clear();
  if (size == 0) return voxels_;
  unsure_.assign(size, 0);
  changes_.resize(size);
  places_.resize(size + 1);
  std::array<AxisTransform, 3> transforms;
  for (int i = 0; i < 3; ++i) {
    const auto axis = static_cast<std::size_t>(i);
    transforms[axis] = {R_WC(i, 0), R_WC(i, 1), R_WC(i, 2), p_WC[i]};
    keys_[axis].resize(size);
    RowVoxels(z, m_x, m_y, count, min_depth, transforms[axis],
              static_cast<float>(inverse_resolution), keys_[axis].data(), unsure_.data());
  }
  MarkChanges(keys_[0].data(), keys_[1].data(), keys_[2].data(), unsure_.data(), count,
              changes_.data());
  // Most pixels fall into the voxel of the previous pixel: the others are selected without a
  // branch.
  std::size_t place_count = 0;
  for (std::size_t i = 0; i < size; ++i) {
    places_[place_count] = i;
    place_count += static_cast<std::size_t>(changes_[i]);
  }
  for (std::size_t i = 0; i < place_count; ++i) {
    const std::size_t u = places_[i];
    VoxelKey key{keys_[0][u], keys_[1][u], keys_[2][u]};
    if (unsure_[u] != 0) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        key[axis] = ToVoxel(transforms[axis](m_x[u], m_y[u], z[u]), inverse_resolution);
      }
    }
    if (IsInside(key)) voxels_.push_back(key);
  }
  return voxels_;
}

}  // namespace highwall::internal
