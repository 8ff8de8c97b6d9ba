#include "report/report_scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include <Eigen/Geometry>
#include <nlohmann/json.hpp>

#include <highwall/mapping/keyframe_cloud.h>
#include <highwall/mapping/map_comparison.h>

#include "report/base64.h"
#include "run/run_files.h"

namespace highwall::apps {
namespace {

constexpr double kSteps = std::numeric_limits<std::uint16_t>::max();

using Cell = std::array<std::uint16_t, 3>;

// Cells of the octree in units of `size`, relative to `low`.
std::vector<Cell> CellsOf(std::span<const Eigen::Vector3f> centres, const Eigen::Vector3f& low,
                          double size) {
  std::vector<Cell> cells;
  for (const Eigen::Vector3f& centre : centres) {
    const Eigen::Vector3d at = (centre - low).cast<double>() / size;
    // An offset of half the smallest cell avoids rounding at the edges of larger cells.
    const auto index = [](double value) {
      return static_cast<std::uint16_t>(std::clamp(std::floor(value), 0.0, kSteps));
    };
    cells.push_back({index(at.x()), index(at.y()), index(at.z())});
  }
  std::ranges::sort(cells);
  cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
  return cells;
}

nlohmann::json Triple(const Eigen::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}

}  // namespace

std::vector<ColoredPoint> ThinPoints(std::vector<ColoredPoint> points, std::size_t limit) {
  if (points.size() <= limit) return points;
  Eigen::AlignedBox3f box;
  for (const ColoredPoint& point : points) box.extend(point.p);
  // FilterVoxels supports 2^20 voxels to each side of the origin.
  const double farthest =
      std::max(box.min().cwiseAbs().maxCoeff(), box.max().cwiseAbs().maxCoeff());
  double voxel = std::max(0.005, farthest / (1 << 19));
  std::vector<ColoredPoint> thinned = FilterVoxels(points, voxel);
  while (thinned.size() > limit) {
    // On surfaces, doubling the voxel size leaves a quarter of the points.
    const double share = static_cast<double>(thinned.size()) / static_cast<double>(limit);
    voxel *= std::max(1.05, std::sqrt(share));
    thinned = FilterVoxels(points, voxel);
  }
  return thinned;
}

nlohmann::json CloudJson(std::vector<ColoredPoint> points, std::size_t limit) {
  std::erase_if(points, [](const ColoredPoint& point) { return !point.p.allFinite(); });
  if (points.empty()) return nullptr;
  const std::size_t before = points.size();
  const std::vector<ColoredPoint> thinned = ThinPoints(std::move(points), limit);
  Eigen::AlignedBox3d box;
  for (const ColoredPoint& point : thinned) box.extend(point.p.cast<double>());
  const double step = std::max(box.sizes().maxCoeff() / kSteps, 1e-6);
  std::vector<std::uint16_t> positions;
  std::vector<std::uint8_t> colours;
  for (const ColoredPoint& point : thinned) {
    const Eigen::Vector3d at = (point.p.cast<double>() - box.min()) / step;
    for (int axis = 0; axis < 3; ++axis) {
      positions.push_back(static_cast<std::uint16_t>(std::min(std::round(at[axis]), kSteps)));
    }
    colours.insert(colours.end(), point.rgb.begin(), point.rgb.end());
  }
  return {{"count", thinned.size()},
          {"of", before},
          {"low", Triple(box.min())},
          {"step", step},
          {"positions", Base64Of(std::span<const std::uint16_t>(positions))},
          {"colours", Base64Of(std::span<const std::uint8_t>(colours))}};
}

nlohmann::json OctreeJson(const OctomapBuilder& octree, std::size_t limit) {
  const std::vector<Eigen::Vector3f> centres = OccupiedCentres(octree);
  if (centres.empty()) return nullptr;
  const double resolution = octree.options().resolution;
  Eigen::Vector3f corner = centres.front();
  for (const Eigen::Vector3f& centre : centres) corner = corner.cwiseMin(centre);
  corner.array() -= static_cast<float>(0.5 * resolution);
  double size = resolution;
  std::vector<Cell> cells = CellsOf(centres, corner, size);
  while (cells.size() > limit) {
    size *= 2.0;
    cells = CellsOf(centres, corner, size);
  }
  const std::span<const std::uint16_t> flat(cells.front().data(), 3 * cells.size());
  return {{"count", cells.size()},
          {"size", size},
          {"resolution", resolution},
          {"low", Triple(corner.cast<double>().array() + 0.5 * size)},
          {"cells", Base64Of(flat)}};
}

nlohmann::json SceneJson(const std::filesystem::path& folder, std::size_t place,
                         const SceneLimits& limits) {
  const auto at = [&](const char* name) { return folder / NameOfSubmap(name, place); };
  nlohmann::json scene = nlohmann::json::object();
  if (const auto path = at(kCloudFile); std::filesystem::exists(path)) {
    scene["cloud"] = CloudJson(ReadPly(path), limits.points);
  }
  if (const auto path = at(kOctreeFile); std::filesystem::exists(path)) {
    scene["octree"] = OctreeJson(OctomapBuilder::Read(path), limits.voxels);
  }
  return scene;
}

}  // namespace highwall::apps
