#include "scan_voxels.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace highwall::internal {
namespace {

constexpr int kKeyOffset = 32768;  // the voxel at the origin of W, as in OctoMap
constexpr std::uint64_t kNoBrick = ~std::uint64_t{0};

// abc -> a00b00c.
constexpr std::array<unsigned, 8> kSpread = {0, 1, 8, 9, 64, 65, 72, 73};

// Bit of a voxel in its brick.
unsigned MortonInBrick(const std::array<int, 3>& k) {
  return kSpread[static_cast<unsigned>(k[0]) & 7u] |
         kSpread[static_cast<unsigned>(k[1]) & 7u] << 1 |
         kSpread[static_cast<unsigned>(k[2]) & 7u] << 2;
}

// Interleaves the 13 bits of each brick coordinate, x lowest.
std::uint64_t MortonOfBrick(const std::array<int, 3>& k) {
  std::uint64_t morton = 0;
  for (unsigned bit = 0; bit < 13; ++bit) {
    for (unsigned axis = 0; axis < 3; ++axis) {
      const auto coordinate = static_cast<std::uint64_t>(k[axis]) >> 3;
      morton |= ((coordinate >> bit) & 1u) << (3 * bit + axis);
    }
  }
  return morton;
}

void SetBit(std::array<std::uint64_t, 8>& words, unsigned morton) {
  words[morton >> 6] |= std::uint64_t{1} << (morton & 63u);
}

// Voxel of a coordinate [m]; outside of the map (IsInside) where there is none, or for a NaN.
inline int ToVoxel(float coordinate, double inverse_resolution) {
  double scaled = inverse_resolution * static_cast<double>(coordinate);
  scaled = scaled > -kKeyOffset ? scaled : -kKeyOffset;
  scaled = scaled < kKeyOffset ? scaled : kKeyOffset;
  const int truncated = static_cast<int>(scaled);
  return truncated - (scaled < truncated ? 1 : 0) + kKeyOffset;
}

// One voxel of margin, for a ray that oversteps its end.
inline bool IsInside(const std::array<int, 3>& k) {
  return k[0] > 0 && k[1] > 0 && k[2] > 0 && k[0] < 2 * kKeyOffset - 1 &&
         k[1] < 2 * kKeyOffset - 1 && k[2] < 2 * kKeyOffset - 1;
}

// One row of p_W = R_WC p_C + p_WC, and the voxels to the metre.
struct AxisTransform {
  float r_x, r_y, r_z, t;
  double inverse_resolution;
};

// The hot loop of a scan, over every pixel: kept free of branches so that it compiles to vector
// instructions. (AVX2 without FMA: both clones round alike.)
__attribute__((target_clones("avx2", "default"))) void RowVoxels(
    const float* __restrict z, const float* __restrict m_x, const float* __restrict m_y, int count,
    float min_depth, const AxisTransform& transform, int* __restrict voxels) {
  const AxisTransform a = transform;
  constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
  for (int i = 0; i < count; ++i) {
    const float depth = z[i] >= min_depth ? z[i] : kNone;
    const float p_W = a.r_x * (m_x[i] * depth) + a.r_y * (m_y[i] * depth) + a.r_z * depth + a.t;
    voxels[i] = ToVoxel(p_W, a.inverse_resolution);
  }
}

}  // namespace

ScanVoxels::ScanVoxels(double resolution, double max_range)
    : resolution_(resolution), inverse_resolution_(1.0 / resolution), max_range_(max_range) {}

bool ScanVoxels::Start(const octomap::point3d& origin_W) {
  origin_ = origin_W;
  last_endpoint_ = {{-1, -1, -1}};
  endpoints_.clear();
  index_.Clear();
  bricks_.clear();
  last_brick_key_ = kNoBrick;
  return ToKey(origin_, origin_key_);
}

bool ScanVoxels::ToKey(const octomap::point3d& p_W, Key& key) const {
  for (unsigned i = 0; i < 3; ++i) key.k[i] = ToVoxel(p_W(i), inverse_resolution_);
  return IsInside(key.k);
}

double ScanVoxels::CenterCoordinate(int k) const {
  return (static_cast<double>(k - kKeyOffset) + 0.5) * resolution_;
}

octomap::point3d ScanVoxels::Center(const Key& key) const {
  return {static_cast<float>(CenterCoordinate(key.k[0])),
          static_cast<float>(CenterCoordinate(key.k[1])),
          static_cast<float>(CenterCoordinate(key.k[2]))};
}

VoxelBrick& ScanVoxels::BrickAt(const Key& key) {
  const std::uint64_t brick_key = static_cast<std::uint64_t>(key.k[0] >> 3) |
                                  static_cast<std::uint64_t>(key.k[1] >> 3) << 13 |
                                  static_cast<std::uint64_t>(key.k[2] >> 3) << 26;
  // Neighbouring pixels and neighbouring voxels of a ray mostly share a brick.
  if (brick_key != last_brick_key_) {
    last_brick_key_ = brick_key;
    last_brick_ = index_.Insert(brick_key);
    if (last_brick_ == bricks_.size()) bricks_.emplace_back().morton = MortonOfBrick(key.k);
  }
  return bricks_[last_brick_];
}

void ScanVoxels::AddPoints(std::span<const Eigen::Vector3f> points_W) {
  for (const Eigen::Vector3f& p : points_W) {
    Key key;
    if (ToKey({p.x(), p.y(), p.z()}, key)) AddEndpoint(key);
  }
}

void ScanVoxels::AddDepthRow(const float* z, const float* m_x, const float* m_y, int count,
                             float min_depth, const Eigen::Matrix3f& R_WC,
                             const Eigen::Vector3f& p_WC) {
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<int>& keys = row_keys_[static_cast<std::size_t>(axis)];
    keys.resize(static_cast<std::size_t>(count));
    const AxisTransform transform{R_WC(axis, 0), R_WC(axis, 1), R_WC(axis, 2), p_WC[axis],
                                  inverse_resolution_};
    RowVoxels(z, m_x, m_y, count, min_depth, transform, keys.data());
  }
  for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
    const Key key{{row_keys_[0][i], row_keys_[1][i], row_keys_[2][i]}};
    if (key != last_endpoint_ && IsInside(key.k)) AddEndpoint(key);
  }
}

void ScanVoxels::AddEndpoint(const Key& key) {
  last_endpoint_ = key;
  std::array<std::uint64_t, 8>& seen = BrickAt(key).seen;
  const unsigned morton = MortonInBrick(key.k);
  if ((seen[morton >> 6] >> (morton & 63u)) & 1u) return;
  SetBit(seen, morton);
  endpoints_.push_back(key);
}

std::span<const VoxelBrick> ScanVoxels::Finish() {
  for (const Key& key : endpoints_) {
    const octomap::point3d center = Center(key);
    const octomap::point3d ray = center - origin_;
    if (ray.norm() <= max_range_) {
      SetBit(BrickAt(key).occupied, MortonInBrick(key.k));
      CastRay(center);
    } else {
      CastRay(origin_ + ray.normalized() * static_cast<float>(max_range_));
    }
  }
  for (VoxelBrick& brick : bricks_) {
    for (std::size_t i = 0; i < 8; ++i) {
      brick.free[i] &= ~brick.occupied[i];
      brick.any_free |= brick.free[i] != 0;
      brick.any_occupied |= brick.occupied[i] != 0;
    }
  }
  std::erase_if(bricks_, [](const VoxelBrick& b) { return !b.any_free && !b.any_occupied; });
  std::sort(bricks_.begin(), bricks_.end(),
            [](const VoxelBrick& a, const VoxelBrick& b) { return a.morton < b.morton; });
  return bricks_;
}

// Amanatides and Woo, "A fast voxel traversal algorithm for ray tracing", Eurographics 1987, in the
// same mixed precision as OctoMap: a ray through an edge of voxels must take the same side there.
void ScanVoxels::CastRay(const octomap::point3d& end) {
  constexpr double kNever = std::numeric_limits<double>::max();
  Key key_end;
  if (!ToKey(end, key_end) || key_end == origin_key_) return;
  octomap::point3d direction = end - origin_;
  const auto length = static_cast<float>(direction.norm());
  direction /= length;

  Key key = origin_key_;
  std::array<int, 3> step{};
  std::array<double, 3> next{}, delta{};  // distance to the next border; between two borders
  for (unsigned i = 0; i < 3; ++i) {
    const double d = direction(i);
    step[i] = (d > 0.0) - (d < 0.0);
    const auto half = static_cast<float>(step[i] * resolution_ * 0.5);
    next[i] = step[i] ? (CenterCoordinate(key.k[i]) + half - origin_(i)) / d : kNever;
    delta[i] = step[i] ? resolution_ / std::abs(d) : kNever;
  }
  double nearest = 0.0;
  // Rounding can lead the walk past the end voxel: the length stops it there.
  do {
    SetBit(BrickAt(key).free, MortonInBrick(key.k));
    const std::size_t xy = next[0] < next[1] ? 0 : 1;
    const std::size_t axis = next[xy] < next[2] ? xy : 2;
    key.k[axis] += step[axis];
    next[axis] += delta[axis];
    nearest = std::min({next[0], next[1], next[2]});
  } while (key != key_end && nearest <= length);
}

}  // namespace highwall::internal
