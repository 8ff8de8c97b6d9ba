#include "scan_voxels.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace highwall::internal {
namespace {

constexpr int kKeyOffset = 32768;  // the voxel at the origin of W, as in OctoMap
constexpr std::uint64_t kNoBrick = ~std::uint64_t{0};

// The bits of the Morton index that belong to x; those of y and z follow to the left.
constexpr std::uint64_t kMaskX = 0x249249249249;

// Spreads 16 bits to every third place.
std::uint64_t Spread(int k) {
  auto bits = static_cast<std::uint64_t>(k);
  bits = (bits | bits << 16) & 0x0000FF0000FF;
  bits = (bits | bits << 8) & 0x00F00F00F00F;
  bits = (bits | bits << 4) & 0x0C30C30C30C3;
  return (bits | bits << 2) & kMaskX;
}

// The path of a voxel from the root of the octree, three bits a level, x lowest.
std::uint64_t Morton(const std::array<int, 3>& k) {
  return Spread(k[0]) | Spread(k[1]) << 1 | Spread(k[2]) << 2;
}

// voxel: Morton index; its lowest nine bits are the place in the brick.
void SetBit(std::array<std::uint64_t, 8>& words, std::uint64_t voxel) {
  words[voxel >> 6 & 7u] |= std::uint64_t{1} << (voxel & 63u);
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
    const float p_W = a.r_x * (m_x[i] * depth) + (a.r_y * (m_y[i] * depth) + a.r_z * depth) + a.t;
    voxels[i] = ToVoxel(p_W, a.inverse_resolution);
  }
}

}  // namespace

ScanVoxels::ScanVoxels(double resolution, double max_range)
    : resolution_(resolution), inverse_resolution_(1.0 / resolution), max_range_(max_range) {}

bool ScanVoxels::Start(const octomap::point3d& origin_W) {
  origin_ = origin_W;
  endpoints_.clear();
  index_.Clear();
  bricks_.clear();
  last_brick_morton_ = kNoBrick;
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

VoxelBrick& ScanVoxels::BrickAt(std::uint64_t voxel) {
  const std::uint64_t morton = voxel >> 9;
  // Neighbouring pixels and neighbouring voxels of a ray mostly share a brick.
  if (morton != last_brick_morton_) {
    last_brick_morton_ = morton;
    last_brick_ = index_.Insert(morton);
    if (last_brick_ == bricks_.size()) bricks_.emplace_back().morton = morton;
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
  // Most pixels fall into the voxel of the pixel before: pick out the others without a branch.
  const auto& [kx, ky, kz] = row_keys_;
  row_changes_.resize(static_cast<std::size_t>(count) + 1);
  std::size_t change_count = 1;
  row_changes_[0] = 0;
  for (std::size_t i = 1; i < kx.size(); ++i) {
    row_changes_[change_count] = i;
    change_count += ((kx[i] ^ kx[i - 1]) | (ky[i] ^ ky[i - 1]) | (kz[i] ^ kz[i - 1])) != 0;
  }
  for (std::size_t i = 0; i < change_count; ++i) {
    const std::size_t u = row_changes_[i];
    const Key key{{kx[u], ky[u], kz[u]}};
    if (IsInside(key.k)) AddEndpoint(key);
  }
}

void ScanVoxels::AddEndpoint(const Key& key) {
  const std::uint64_t voxel = Morton(key.k);
  std::uint64_t& word = BrickAt(voxel).seen[voxel >> 6 & 7u];
  const std::uint64_t bit = std::uint64_t{1} << (voxel & 63u);
  if ((word & bit) != 0) return;
  word |= bit;
  endpoints_.push_back(key);
}

std::span<const VoxelBrick> ScanVoxels::Finish() {
  for (const Key& key : endpoints_) {
    const octomap::point3d center = Center(key);
    const octomap::point3d ray = center - origin_;
    if (ray.norm() <= max_range_) {
      const std::uint64_t voxel = Morton(key.k);
      SetBit(BrickAt(voxel).occupied, voxel);
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

  const std::uint64_t voxel_end = Morton(key_end.k);
  std::array<std::uint64_t, 3> voxel{}, mask{}, step{};  // per axis, spread
  std::array<double, 3> next{}, delta{};  // distance to the next border; between two borders
  for (unsigned i = 0; i < 3; ++i) {
    const double d = direction(i);
    const int sign = (d > 0.0) - (d < 0.0);
    const auto half = static_cast<float>(sign * resolution_ * 0.5);
    next[i] = sign ? (CenterCoordinate(origin_key_.k[i]) + half - origin_(i)) / d : kNever;
    delta[i] = sign ? resolution_ / std::abs(d) : kNever;
    mask[i] = kMaskX << i;
    voxel[i] = Spread(origin_key_.k[i]) << i;
    step[i] = sign < 0 ? mask[i] : std::uint64_t{1} << i;  // all ones is minus one
  }
  double nearest = 0.0;
  // Rounding can lead the walk past the end voxel: the length stops it there.
  do {
    const std::uint64_t at = voxel[0] | voxel[1] | voxel[2];
    SetBit(BrickAt(at).free, at);
    const std::size_t xy = next[0] < next[1] ? 0 : 1;
    const std::size_t axis = next[xy] < next[2] ? xy : 2;
    // Ones in the gaps carry the sum across them.
    voxel[axis] = ((voxel[axis] | ~mask[axis]) + step[axis]) & mask[axis];
    next[axis] += delta[axis];
    nearest = std::min({next[0], next[1], next[2]});
  } while ((voxel[0] | voxel[1] | voxel[2]) != voxel_end && nearest <= length);
}

}  // namespace highwall::internal
