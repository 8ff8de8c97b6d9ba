#include <highwall/mapping/map_comparison.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Geometry>

#include <highwall/core/error.h>
#include <highwall/internal/number_text.h>
#include <highwall/internal/require.h>

#include "kd_tree.h"

namespace highwall {
namespace {

constexpr double kMaxSamples = 1 << 27;

DistanceStatistics Summarize(std::vector<float>& distances) {
  std::ranges::sort(distances);
  double sum = 0.0;
  for (const float distance : distances) sum += distance;
  const auto at = [&](double share) {
    return distances[static_cast<std::size_t>(share * static_cast<double>(distances.size() - 1))];
  };
  return {.mean = sum / static_cast<double>(distances.size()),
          .median = at(0.5),
          .percentile_90 = at(0.9),
          .count = distances.size()};
}

double ShareBelow(const std::vector<float>& sorted, double threshold) {
  const auto end = std::ranges::upper_bound(sorted, static_cast<float>(threshold));
  return static_cast<double>(end - sorted.begin()) / static_cast<double>(sorted.size());
}

std::vector<Eigen::Vector3f> Finite(std::span<const Eigen::Vector3f> points) {
  std::vector<Eigen::Vector3f> finite;
  std::ranges::copy_if(points, std::back_inserter(finite),
                       [](const Eigen::Vector3f& p) { return p.allFinite(); });
  return finite;
}

// The two shorter edges of a triangle, from the corner where they meet.
struct Legs {
  Eigen::Vector3f corner, u, v;

  explicit Legs(const std::array<Eigen::Vector3f, 3>& t) {
    std::size_t i = 0;  // opposite to the longest edge
    const auto opposite = [&](std::size_t k) {
      return (t[(k + 1) % 3] - t[(k + 2) % 3]).squaredNorm();
    };
    for (std::size_t k = 1; k < 3; ++k) {
      if (opposite(k) > opposite(i)) i = k;
    }
    corner = t[i];
    u = t[(i + 1) % 3] - corner;
    v = t[(i + 2) % 3] - corner;
  }
};

double Steps(const Eigen::Vector3f& edge, double spacing) {
  return std::max(1.0, std::ceil(static_cast<double>(edge.norm()) / spacing));
}

// Samples a triangle on a lattice of that spacing or slightly less, corners included.
void SampleTriangle(const Legs& legs, double spacing, std::vector<Eigen::Vector3f>& samples) {
  const int n_u = static_cast<int>(Steps(legs.u, spacing));
  const int n_v = static_cast<int>(Steps(legs.v, spacing));
  for (int i = 0; i <= n_u; ++i) {
    const float u = static_cast<float>(i) / static_cast<float>(n_u);
    for (int j = 0; j <= n_v; ++j) {
      const float v = static_cast<float>(j) / static_cast<float>(n_v);
      if (u + v <= 1.0f) samples.push_back(legs.corner + u * legs.u + v * legs.v);
    }
  }
}

}  // namespace

float SquaredDistanceToTriangle(const Eigen::Vector3f& p,
                                const std::array<Eigen::Vector3f, 3>& abc) {
  const auto& [a, b, c] = abc;
  const Eigen::Vector3f ab = b - a, ac = c - a, normal = ab.cross(ac);
  const auto to_edge = [&](const Eigen::Vector3f& from, const Eigen::Vector3f& edge) {
    const float length = edge.squaredNorm();
    const float t = length > 0.0f ? std::clamp((p - from).dot(edge) / length, 0.0f, 1.0f) : 0.0f;
    return (p - from - t * edge).squaredNorm();
  };
  const float area = normal.squaredNorm();
  if (area > 0.0f) {
    // Barycentric coordinates of the foot of the perpendicular.
    const Eigen::Vector3f ap = p - a;
    const float v = ap.cross(ac).dot(normal) / area, w = ab.cross(ap).dot(normal) / area;
    if (v >= 0.0f && w >= 0.0f && v + w <= 1.0f) {
      const float height = ap.dot(normal);
      return height * height / area;
    }
  }
  return std::min({to_edge(a, ab), to_edge(a, ac), to_edge(b, c - b)});
}

ReferenceSurface::ReferenceSurface(std::vector<Eigen::Vector3f> points)
    : points_(Finite(points)), samples_(points_) {
  HIGHWALL_REQUIRE(!points_.empty(), "the reference has no finite point");
}

ReferenceSurface::ReferenceSurface(const TriangleMesh& mesh, double spacing) {
  RequirePositive(spacing, "spacing");
  double expected = 0.0;
  for (const auto& indices : mesh.triangles) {
    std::array<Eigen::Vector3f, 3> triangle;
    for (std::size_t i = 0; i < 3; ++i) triangle[i] = mesh.vertices.at(indices[i]).p;
    const Legs legs(triangle);
    if (!legs.u.allFinite() || !legs.v.allFinite()) continue;
    expected += 0.5 * (Steps(legs.u, spacing) + 2.0) * (Steps(legs.v, spacing) + 2.0);
    triangles_.push_back(triangle);
  }
  HIGHWALL_REQUIRE(!triangles_.empty(), "the reference has no triangle");
  HIGHWALL_REQUIRE(expected < kMaxSamples,
                   "a spacing of " + FixedText(spacing) + " m makes too many samples");
  for (std::size_t i = 0; i < triangles_.size(); ++i) {
    SampleTriangle(Legs(triangles_[i]), spacing, points_);
    triangle_of_point_.resize(points_.size(), static_cast<std::uint32_t>(i));
  }
  // Edges belong to two triangles, and small triangles have more corners than area: the samples are
  // thinned out to a uniform density.
  std::vector<ColoredPoint> all;
  for (const Eigen::Vector3f& p : points_) all.push_back({.p = p});
  for (const ColoredPoint& point : FilterVoxels(all, 0.5 * spacing)) samples_.push_back(point.p);
}

void ReferenceSurface::KeepSamples(const std::vector<char>& keep) {
  HIGHWALL_REQUIRE(keep.size() == samples_.size(), "there must be one entry for each sample");
  std::size_t i = 0;
  std::erase_if(samples_, [&](const Eigen::Vector3f&) { return keep[i++] == 0; });
  HIGHWALL_REQUIRE(!samples_.empty(), "no sample of the reference is left");
}

void MarkSeen(std::span<const Eigen::Vector3f> points_W, const DepthView& view,
              const PinholeCamera& camera, double tolerance, std::vector<char>& seen) {
  HIGHWALL_REQUIRE(seen.size() == points_W.size(), "there must be one entry for each point");
  HIGHWALL_REQUIRE(view.depth.type() == CV_32FC1 && view.depth.cols == camera.width &&
                       view.depth.rows == camera.height,
                   "a depth image is CV_32FC1, of the size of the camera");
  const Pose T_CW = view.T_WC.Inverse();
  const Eigen::Matrix3d R_CW = T_CW.R();
  for (std::size_t i = 0; i < points_W.size(); ++i) {
    if (seen[i] != 0) continue;
    const Eigen::Vector3d p_C = R_CW * points_W[i].cast<double>() + T_CW.p();
    // Well outside of the image the distortion model may fold over: points outside of a wide cone
    // are rejected first.
    if (!(p_C.z() > 0.0) || p_C.head<2>().norm() > 2.0 * p_C.z()) continue;
    const Eigen::Vector2d uv = camera.Project(p_C);
    if (!camera.Contains(uv)) continue;
    const double z = view.depth.at<float>(static_cast<int>(std::lround(uv.y())),
                                          static_cast<int>(std::lround(uv.x())));
    if (z > 0.0 && std::abs(z - p_C.z()) <= tolerance) seen[i] = 1;
  }
}

std::vector<Eigen::Vector3f> OccupiedCentres(const OctomapBuilder& map) {
  std::vector<Eigen::Vector3f> centres;
  const double resolution = map.options().resolution;
  map.ForEachLeaf([&](const OctreeLeaf& leaf) {
    if (!leaf.occupied) return;
    const int n = static_cast<int>(std::lround(leaf.size / resolution));
    const Eigen::Vector3d first =
        leaf.center_W - Eigen::Vector3d::Constant(0.5 * resolution * (n - 1));
    for (int i = 0; i < n * n * n; ++i) {
      const Eigen::Vector3d step(i % n, i / n % n, i / (n * n));
      centres.push_back((first + resolution * step).cast<float>());
    }
  });
  return centres;
}

MapComparison CompareMaps(std::span<const Eigen::Vector3f> points,
                          const ReferenceSurface& reference, std::span<const double> thresholds) {
  std::vector<Eigen::Vector3f> map_points = Finite(points);
  HIGHWALL_REQUIRE(!map_points.empty(), "the map has no finite point");

  // For a mesh, the nearest triangle is among those of the nearest samples.
  constexpr std::size_t kCandidates = 8;
  const bool mesh = !reference.triangles_.empty();
  const internal::KdTree surface(reference.points_);
  std::vector<internal::KdTree::Neighbour> found;
  std::vector<float> to_reference, to_map;
  for (const Eigen::Vector3f& p : map_points) {
    surface.Nearest(p, mesh ? kCandidates : 1, found);
    float nearest = found.front().squared_distance;
    for (std::size_t i = 0; mesh && i < found.size(); ++i) {
      const std::uint32_t triangle = reference.triangle_of_point_[found[i].index];
      nearest = std::min(nearest, SquaredDistanceToTriangle(p, reference.triangles_[triangle]));
    }
    to_reference.push_back(std::sqrt(nearest));
  }
  const internal::KdTree map(std::move(map_points));
  for (const Eigen::Vector3f& p : reference.samples_) {
    to_map.push_back(std::sqrt(map.Nearest(p).squared_distance));
  }
  MapComparison result;
  result.accuracy = Summarize(to_reference);
  result.completeness = Summarize(to_map);
  for (const double threshold : thresholds) {
    const double precision = ShareBelow(to_reference, threshold);
    const double recall = ShareBelow(to_map, threshold);
    const double sum = precision + recall;
    result.thresholds.push_back(
        {threshold, precision, recall, sum > 0.0 ? 2.0 * precision * recall / sum : 0.0});
  }
  return result;
}

}  // namespace highwall
