#include "map/projection_matcher.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <highwall/frontend/features/orb_matcher.h>

namespace highwall {
namespace {

constexpr int kNoHamming = std::numeric_limits<int>::max();

struct ScoredFeature {
  int feature = -1;
  int hamming = kNoHamming;
};

double AngleDifference(double a, double b) {
  return std::abs(std::remainder(a - b, 360.0));
}

// Returns the best feature in the window, -1 if none passes. window, candidates: scratch memory.
ScoredFeature FindBest(const FrameFeatures& features, const ProjectedPoint& projection,
                       const std::vector<bool>& taken, const ProjectionMatchOptions& options,
                       std::vector<int>& window, std::vector<ScoredFeature>& candidates) {
  features.point_grid.Query(projection.uv, projection.radius, projection.min_octave,
                            projection.max_octave, &window);
  candidates.clear();
  ScoredFeature best;
  for (const int i : window) {
    const auto index = static_cast<std::size_t>(i);
    if (taken[index]) continue;
    const PointFeature& feature = features.points[index];
    if (projection.angle && feature.angle >= 0.0F &&
        AngleDifference(static_cast<double>(*projection.angle),
                        static_cast<double>(feature.angle)) > options.max_angle_diff) {
      continue;
    }
    const int hamming =
        HammingDistance(projection.descriptor.data(), features.point_descriptors.ptr(i));
    if (hamming < best.hamming) best = {i, hamming};
    candidates.push_back({i, hamming});
  }
  if (best.feature < 0 || best.hamming > options.max_hamming) return {};
  // A corner repeats on neighbouring levels; only a competitor on the same level makes it
  // ambiguous.
  const auto octave = [&](const ScoredFeature& candidate) {
    return features.points[static_cast<std::size_t>(candidate.feature)].octave;
  };
  for (const ScoredFeature& rival : candidates) {
    if (rival.feature != best.feature && octave(rival) == octave(best) &&
        best.hamming > options.ratio * rival.hamming) {
      return {};
    }
  }
  return best;
}

}  // namespace

std::vector<ProjectionMatch> MatchProjections(const FrameFeatures& features,
                                              std::span<const ProjectedPoint> projections,
                                              const std::vector<bool>& taken,
                                              const ProjectionMatchOptions& options) {
  // The best projection of each feature so far.
  std::vector<ProjectionMatch> owner(features.points.size(), {-1, -1, kNoHamming});
  std::vector<int> window;
  std::vector<ScoredFeature> candidates;
  for (std::size_t j = 0; j < projections.size(); ++j) {
    const ScoredFeature best =
        FindBest(features, projections[j], taken, options, window, candidates);
    if (best.feature < 0) continue;
    ProjectionMatch& match = owner[static_cast<std::size_t>(best.feature)];
    if (best.hamming < match.hamming) match = {best.feature, static_cast<int>(j), best.hamming};
  }
  std::erase_if(owner, [](const ProjectionMatch& m) { return m.feature < 0; });
  return owner;
}

std::optional<LineSegment> ProjectSegment(const Segment3& segment_C, const PinholeCamera& camera,
                                          double min_depth) {
  Eigen::Vector3d p = segment_C.p(), q = segment_C.q();
  if (p.z() < min_depth && q.z() < min_depth) return std::nullopt;
  const auto clip_near = [&](Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    if (a.z() < min_depth) a += (b - a) * ((min_depth - a.z()) / (b.z() - a.z()));
  };
  clip_near(p, q);
  clip_near(q, p);
  const Eigen::Vector2d s = camera.Project(p), e = camera.Project(q);

  // Liang-Barsky clipping to the image.
  double t0 = 0.0, t1 = 1.0;
  const Eigen::Vector2d d = e - s;
  const double limits[2] = {camera.width - 1.0, camera.height - 1.0};
  for (int axis = 0; axis < 2; ++axis) {
    if (d[axis] == 0.0) {
      if (s[axis] < 0.0 || s[axis] > limits[axis]) return std::nullopt;
      continue;
    }
    const double a = -s[axis] / d[axis], b = (limits[axis] - s[axis]) / d[axis];
    t0 = std::max(t0, std::min(a, b));
    t1 = std::min(t1, std::max(a, b));
  }
  if (t0 >= t1) return std::nullopt;
  return LineSegment{(s + t0 * d).cast<float>(), (s + t1 * d).cast<float>()};
}

}  // namespace highwall
