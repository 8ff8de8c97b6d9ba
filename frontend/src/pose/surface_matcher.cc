#include "pose/surface_matcher.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <optional>

#include <Eigen/Eigenvalues>

#include <highwall/core/error.h>

namespace highwall {
namespace {

constexpr int kStride = 2;                // [cells] between the centres of patches
constexpr int kRadius = 4;                // [cells] a patch has 2 kRadius + 1 cells to a side
constexpr double kMinSurfaceShare = 0.7;  // of the cells of a patch that must belong to its surface
constexpr double kMaxIncidence = 1.3;     // [rad] between the ray and the normal
// [rad] Standard deviation of a normal. Less certain normals would constrain a pose in directions
// that the surface does not observe.
constexpr double kMaxTilt = 0.05;
constexpr double kLink = 0.1;  // a patch ends at a relative change of depth above this
// Maximum RMS distance of a patch's cells from the plane: a multiple of the depth noise, or a
// distance [m], whichever is larger.
constexpr double kPlanarSigmas = 2.0;
constexpr double kRoughness = 0.01;
constexpr int kMaxRows = 300;

Eigen::Vector3d PointOf(const cv::Mat& depth, const DepthGrid& grid, const cv::Point& cell) {
  return (depth.at<float>(cell) * grid.Ray(cell)).cast<double>();
}

std::optional<SurfacePatch> FitPatch(const cv::Mat& depth, const DepthGrid& grid,
                                     const cv::Point& middle, const DepthNoise& noise) {
  const auto z = static_cast<double>(depth.at<float>(middle));
  if (z <= 0.0) return std::nullopt;
  const Eigen::Vector3d origin = PointOf(depth, grid, middle);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  int count = 0;
  for (int dv = -kRadius; dv <= kRadius; ++dv) {
    for (int du = -kRadius; du <= kRadius; ++du) {
      const cv::Point cell(middle.x + du, middle.y + dv);
      const auto z_cell = static_cast<double>(depth.at<float>(cell));
      if (z_cell <= 0.0 || std::abs(z_cell - z) > kLink * z) continue;
      const Eigen::Vector3d d = PointOf(depth, grid, cell) - origin;
      sum += d;
      squares.noalias() += d * d.transpose();
      ++count;
    }
  }
  const int side = 2 * kRadius + 1;
  if (count < kMinSurfaceShare * side * side) return std::nullopt;
  const Eigen::Vector3d mean = sum / count;
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen;
  eigen.computeDirect(squares / count - mean * mean.transpose());
  SurfacePatch patch;
  patch.a = origin + mean;
  patch.n = eigen.eigenvectors().col(0);
  if (patch.n.dot(patch.a) > 0.0) patch.n = -patch.n;
  const double cosine = -patch.n.dot(patch.a.normalized());
  if (cosine < std::cos(kMaxIncidence)) return std::nullopt;
  const double rms = std::sqrt(std::max(eigen.eigenvalues()(0), 0.0));
  // Noise is along the ray.
  const double sigma = noise.Sigma(z) * cosine;
  if (rms > std::max(kPlanarSigmas * sigma, kRoughness)) return std::nullopt;
  // Neighbouring readings share much of their noise: a patch is no more accurate than one reading.
  patch.sigma = std::max(rms, sigma);
  const double spread = std::sqrt(count * eigen.eigenvalues()(1));
  if (patch.sigma > kMaxTilt * spread) return std::nullopt;
  return patch;
}

// Directions of normals are binned on the faces of a cube, each with kFaceBins x kFaceBins bins.
constexpr int kFaceBins = 3;
constexpr std::size_t kNormalBins = 6 * kFaceBins * kFaceBins;

std::size_t NormalBin(const Eigen::Vector3d& n) {
  Eigen::Index axis = 0;
  const double largest = n.cwiseAbs().maxCoeff(&axis);
  const auto bin = [&](Eigen::Index i) {
    const double share = 0.5 * (n(i) / largest + 1.0);
    return std::clamp(static_cast<int>(share * kFaceBins), 0, kFaceBins - 1);
  };
  const int face = 2 * static_cast<int>(axis) + (n(axis) > 0.0 ? 1 : 0);
  return static_cast<std::size_t>((face * kFaceBins + bin((axis + 1) % 3)) * kFaceBins +
                                  bin((axis + 2) % 3));
}

}  // namespace

std::vector<SurfacePatch> FindPatches(const cv::Mat& depth, const DepthGrid& grid,
                                      const DepthNoise& noise) {
  std::vector<SurfacePatch> patches;
  for (int v = kRadius; v < depth.rows - kRadius; v += kStride) {
    for (int u = kRadius; u < depth.cols - kRadius; u += kStride) {
      if (const auto patch = FitPatch(depth, grid, {u, v}, noise)) {
        patches.push_back(*patch);
      }
    }
  }
  return patches;
}

std::vector<PointToPlaneRow> MatchPatches(const std::vector<SurfacePatch>& patches_W,
                                          const cv::Mat& depth, const cv::Mat& moving,
                                          const Pose& T_WC, const DepthGrid& grid,
                                          const DepthNoise& noise, double gate) {
  const Pose T_CW = T_WC.Inverse();
  const cv::Rect cells(0, 0, depth.cols, depth.rows);
  std::vector<PointToPlaneRow> rows;
  for (const SurfacePatch& patch : patches_W) {
    const Eigen::Vector3d a_C = T_CW * patch.a;
    if (a_C.z() <= 0.0) continue;
    const Eigen::Vector2f uv = grid.Project(a_C.cast<float>());
    const cv::Point cell(static_cast<int>(std::lround(uv.x())),
                         static_cast<int>(std::lround(uv.y())));
    if (!cells.contains(cell) || (!moving.empty() && moving.at<std::uint8_t>(cell) != 0)) continue;
    const auto z = static_cast<double>(depth.at<float>(cell));
    if (z <= 0.0) continue;
    const Eigen::Vector3d p_C = PointOf(depth, grid, cell);
    const double cosine = std::abs((T_WC.R().transpose() * patch.n).dot(p_C.normalized()));
    const double sigma = std::hypot(patch.sigma, noise.Sigma(z) * cosine);
    const double distance = std::abs(patch.n.dot(T_WC * p_C - patch.a));
    if (distance > kSurfaceGateSigmas * sigma + gate) continue;
    rows.push_back({patch.n, patch.a, p_C, 1.0 / sigma});
  }
  return SpreadOverNormals(rows, kMaxRows);
}

std::vector<PointToPlaneRow> SpreadOverNormals(const std::vector<PointToPlaneRow>& rows,
                                               int max_rows) {
  const auto wanted = static_cast<std::size_t>(max_rows);
  if (rows.size() <= wanted) return rows;
  std::array<std::vector<std::size_t>, kNormalBins> bins;
  for (std::size_t i = 0; i < rows.size(); ++i) bins[NormalBin(rows[i].n)].push_back(i);
  // Maximum number per bin for max_rows in total.
  const auto total = [&](std::size_t most) {
    std::size_t sum = 0;
    for (const auto& bin : bins) sum += std::min(bin.size(), most);
    return sum;
  };
  std::size_t most = 1;
  while (total(most + 1) <= wanted) ++most;
  std::vector<std::size_t> chosen;
  for (const auto& bin : bins) {
    const std::size_t count = std::min(bin.size(), most);
    for (std::size_t k = 0; k < count; ++k) chosen.push_back(bin[k * bin.size() / count]);
  }
  std::sort(chosen.begin(), chosen.end());
  std::vector<PointToPlaneRow> spread;
  for (std::size_t k = 0; k < std::min(chosen.size(), wanted); ++k) {
    spread.push_back(rows[chosen[k]]);
  }
  return spread;
}

}  // namespace highwall
