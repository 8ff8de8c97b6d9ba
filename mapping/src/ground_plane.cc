#include "ground_plane.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <random>
#include <vector>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include <highwall/core/error.h>
#include <highwall/internal/number_text.h>
#include <highwall/internal/require.h>

namespace highwall {
namespace {

// Number of points that suffices to find a plane; more only cost time.
constexpr std::size_t kMaxPoints = 20000;

using Points = std::vector<Eigen::Vector3d>;

bool IsOn(const GroundPlane& plane, const Eigen::Vector3d& p, double thickness) {
  return std::abs(plane.up_W.dot(p) - plane.height) <= thickness;
}

GroundPlane LeastSquares(const Points& points, const GroundPlane& plane, double thickness) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double count = 0.0;
  for (const Eigen::Vector3d& p : points) {
    if (!IsOn(plane, p, thickness)) continue;
    sum += p;
    count += 1.0;
  }
  const Eigen::Vector3d mean = sum / count;
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& p : points) {
    if (IsOn(plane, p, thickness)) scatter += (p - mean) * (p - mean).transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(scatter);
  Eigen::Vector3d up = solver.eigenvectors().col(0);
  if (up.dot(plane.up_W) < 0.0) up = -up;
  return {up, up.dot(mean)};
}

}  // namespace

void GroundPlaneOptions::Validate() const {
  HIGHWALL_REQUIRE(max_tilt > 0.0 && max_tilt < 90.0,
                   "GroundPlaneOptions::max_tilt must lie in (0, 90), is " + FixedText(max_tilt));
  RequirePositive(thickness, "GroundPlaneOptions::thickness");
  HIGHWALL_REQUIRE(min_share > 0.0 && min_share <= 1.0,
                   "GroundPlaneOptions::min_share must lie in (0, 1], is " + FixedText(min_share));
  RequireAtLeast(trials, 1, "GroundPlaneOptions::trials");
}

std::optional<GroundPlane> FitGroundPlane(std::span<const Eigen::Vector3f> points_W,
                                          const Eigen::Vector3d& expected_up_W,
                                          const Eigen::Vector3d& viewpoint_W,
                                          const GroundPlaneOptions& options) {
  options.Validate();
  HIGHWALL_REQUIRE(expected_up_W.allFinite() && !expected_up_W.isZero(0.0),
                   "expected_up_W must be a direction");
  HIGHWALL_REQUIRE(viewpoint_W.allFinite(), "viewpoint_W is not finite");
  Points points;
  const std::size_t stride = std::max<std::size_t>(1, points_W.size() / kMaxPoints);
  for (std::size_t i = 0; i < points_W.size(); i += stride) {
    if (points_W[i].allFinite()) points.push_back(points_W[i].cast<double>());
  }
  if (points.size() < 3) return std::nullopt;

  const Eigen::Vector3d expected = expected_up_W.normalized();
  const double min_cosine = std::cos(options.max_tilt * std::numbers::pi / 180.0);
  std::mt19937_64 rng(1);
  const auto draw = [&] { return points[rng() % points.size()]; };
  std::optional<GroundPlane> best;
  std::size_t best_count = 0;
  for (int trial = 0; trial < options.trials; ++trial) {
    const Eigen::Vector3d a = draw(), b = draw(), c = draw();
    Eigen::Vector3d up = (b - a).cross(c - a).stableNormalized();
    if (up.dot(expected) < 0.0) up = -up;
    if (up.dot(expected) < min_cosine) continue;
    const GroundPlane plane{up, up.dot(a)};
    if (up.dot(viewpoint_W) < plane.height) continue;
    const auto count = static_cast<std::size_t>(std::ranges::count_if(
        points, [&](const Eigen::Vector3d& p) { return IsOn(plane, p, options.thickness); }));
    if (count <= best_count) continue;
    best = plane;
    best_count = count;
  }
  const auto all = static_cast<double>(points.size());
  if (!best || static_cast<double>(best_count) < options.min_share * all) return std::nullopt;
  return LeastSquares(points, *best, options.thickness);
}

}  // namespace highwall
