#include "scan_voxels.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace highwall::internal {

ScanVoxels::ScanVoxels(double resolution, double max_range, double far_range)
    : resolution_(resolution),
      inverse_resolution_(1.0 / resolution),
      max_range_(max_range),
      far_range_(far_range) {}

bool ScanVoxels::Start(const octomap::point3d& origin_W) {
  origin_ = origin_W;
  endpoints_.clear();
  bricks_.Clear();
  return ToKey(origin_, origin_key_);
}

bool ScanVoxels::ToKey(const octomap::point3d& p_W, VoxelKey& key) const {
  for (unsigned i = 0; i < 3; ++i) key[i] = ToVoxel(p_W(i), inverse_resolution_);
  return IsInside(key);
}

double ScanVoxels::CenterCoordinate(int k) const {
  return (static_cast<double>(k - kKeyOffset) + 0.5) * resolution_;
}

octomap::point3d ScanVoxels::Center(const VoxelKey& key) const {
  return {static_cast<float>(CenterCoordinate(key[0])),
          static_cast<float>(CenterCoordinate(key[1])),
          static_cast<float>(CenterCoordinate(key[2]))};
}

void ScanVoxels::AddPoints(std::span<const Eigen::Vector3f> points_W) {
  for (const Eigen::Vector3f& p : points_W) {
    VoxelKey key;
    if (ToKey({p.x(), p.y(), p.z()}, key)) AddEndpoint(key);
  }
}

void ScanVoxels::AddDepthRow(const float* z, const float* m_x, const float* m_y, int count,
                             float min_depth, const Eigen::Matrix3f& R_WC,
                             const Eigen::Vector3f& p_WC) {
  for (const VoxelKey& key :
       pixels_.OfRow(z, m_x, m_y, count, min_depth, R_WC, p_WC, inverse_resolution_)) {
    AddEndpoint(key);
  }
}

void ScanVoxels::AddEndpoint(const VoxelKey& key) {
  const std::uint64_t voxel = Morton(key);
  if (bricks_.BrickOf(voxel).seen.Set(voxel)) endpoints_.push_back(key);
}

void ScanVoxels::CastRays(std::span<const VoxelKey> endpoints) {
  ray_count_ = 0;
  octomap::point3d end;
  for (const VoxelKey& key : endpoints) {
    end = Center(key);
    const octomap::point3d ray = end - origin_;
    const double range = ray.norm();
    if (range <= max_range_) {
      const std::uint64_t voxel = Morton(key);
      VoxelBrick& brick = bricks_.BrickOf(voxel);
      (range <= far_range_ ? brick.occupied : brick.far).Set(voxel);
    } else {
      end = origin_ + ray.normalized() * static_cast<float>(max_range_);
    }
    CastRay(end);
  }
  // The last batch is padded with its own first ray.
  for (int lane = ray_count_; ray_count_ != 0 && lane < kRayLanes; ++lane) {
    for (std::size_t i = 0; i < 3; ++i) {
      rays_.next[i][lane] = rays_.next[i][0];
      rays_.delta[i][lane] = rays_.delta[i][0];
      rays_.voxel[i][lane] = rays_.voxel[i][0];
      rays_.step[i][lane] = rays_.step[i][0];
    }
    rays_.end[lane] = rays_.end[0];
    rays_.length[lane] = rays_.length[0];
  }
  if (ray_count_ != 0) TraverseRays(rays_, bricks_);
}

// Uses the same mixed precision as OctoMap: a ray through an edge of voxels must take the same
// side.
void ScanVoxels::CastRay(const octomap::point3d& end) {
  constexpr double kNever = std::numeric_limits<double>::max();
  VoxelKey key_end;
  if (!ToKey(end, key_end) || key_end == origin_key_) return;
  octomap::point3d direction = end - origin_;
  const auto length = static_cast<float>(direction.norm());
  direction /= length;

  const int lane = ray_count_++;
  for (unsigned i = 0; i < 3; ++i) {
    const double d = direction(i);
    const int sign = (d > 0.0) - (d < 0.0);
    const auto half = static_cast<float>(sign * resolution_ * 0.5);
    rays_.next[i][lane] =
        sign ? (CenterCoordinate(origin_key_[i]) + half - origin_(i)) / d : kNever;
    rays_.delta[i][lane] = sign ? resolution_ / std::abs(d) : kNever;
    const std::uint64_t mask = kMortonMaskX << i;
    rays_.voxel[i][lane] = static_cast<std::int64_t>(Spread(origin_key_[i]) << i);
    // All ones represent minus one.
    rays_.step[i][lane] = static_cast<std::int64_t>(sign < 0 ? mask : std::uint64_t{1} << i);
  }
  rays_.end[lane] = static_cast<std::int64_t>(Morton(key_end));
  rays_.length[lane] = length;
  if (ray_count_ < kRayLanes) return;
  TraverseRays(rays_, bricks_);
  ray_count_ = 0;
}

void ScanVoxels::Merge(ScanVoxels& other) {
  for (const VoxelBrick& theirs : other.bricks_.bricks()) {
    VoxelBrick& ours = bricks_.BrickOf(theirs.morton << 9);
    for (std::size_t i = 0; i < 8; ++i) {
      ours.free.words[i] |= theirs.free.words[i];
      ours.occupied.words[i] |= theirs.occupied.words[i];
      ours.far.words[i] |= theirs.far.words[i];
    }
  }
}

std::vector<VoxelBrick*> ScanVoxels::Finish() {
  std::vector<std::pair<std::uint64_t, VoxelBrick*>> order;
  for (VoxelBrick& brick : bricks_.bricks()) {
    brick.Finish();
    if (brick.any_free || brick.any_occupied || brick.any_far) {
      order.emplace_back(brick.morton, &brick);
    }
  }
  std::sort(order.begin(), order.end());
  std::vector<VoxelBrick*> sorted;
  sorted.reserve(order.size());
  for (const auto& [morton, brick] : order) sorted.push_back(brick);
  return sorted;
}

}  // namespace highwall::internal
