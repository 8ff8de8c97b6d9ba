#include "pose/depth_agreement.h"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

namespace highwall {
namespace {

constexpr double kSigmas = 3.0;
constexpr double kRelative = 0.03;  // of the depth: what a pose just found may be off by
constexpr float kMinDepth = 0.05F;  // [m]
constexpr double kMinShare = 0.05;  // of the cells of a grid that must fall on a reading

struct Count {
  int compared = 0, contradict = 0;

  double Share() const { return static_cast<double>(contradict) / compared; }
};

// Readings of `from` looked up in `onto`.
void LookUp(const cv::Mat& from, const cv::Mat& onto, const Pose& T_onto_from,
            const DepthGrid& grid, const DepthNoise& noise, Count* count) {
  const Eigen::Matrix3f R = T_onto_from.R().cast<float>();
  const Eigen::Vector3f p = T_onto_from.p().cast<float>();
  // A point at an edge may belong to either side.
  cv::Mat nearest;
  cv::Mat filled = onto.clone();
  filled.setTo(1e9F, onto <= 0.0F);
  cv::erode(filled, nearest, cv::Mat());
  for (int v = 0; v < from.rows; ++v) {
    for (int u = 0; u < from.cols; ++u) {
      const float z = from.at<float>(v, u);
      if (z <= 0.0F) continue;
      const Eigen::Vector3f point = R * (z * grid.Ray({u, v})) + p;
      if (point.z() < kMinDepth) continue;
      const Eigen::Vector2f cell = grid.Project(point);
      const cv::Point at(static_cast<int>(std::floor(cell.x() + 0.5F)),
                         static_cast<int>(std::floor(cell.y() + 0.5F)));
      if (at.x < 1 || at.y < 1 || at.x >= onto.cols - 1 || at.y >= onto.rows - 1) continue;
      if (onto.at<float>(at) <= 0.0F) continue;
      ++count->compared;
      const double seen = nearest.at<float>(at);
      const double margin = kSigmas * M_SQRT2 * noise.Sigma(seen) + kRelative * seen;
      if (point.z() < seen - margin) ++count->contradict;
    }
  }
}

}  // namespace

std::optional<double> DepthContradiction(const cv::Mat& depth, const Pose& T_WC,
                                         std::span<const KeyFrameId> keyframes, const Map& map,
                                         const DepthGrid& grid, const DepthNoise& noise) {
  Count gone, come;
  for (const KeyFrameId id : keyframes) {
    const KeyFrame& keyframe = *map.keyframe(id);
    const cv::Mat& other = keyframe.frame.features->depth_grid;
    if (other.empty() || depth.empty()) continue;
    const Pose T = keyframe.T_WC.Inverse() * T_WC;
    LookUp(depth, other, T, grid, noise, &come);
    LookUp(other, depth, T.Inverse(), grid, noise, &gone);
  }
  const double enough = kMinShare * static_cast<double>(depth.total());
  if (gone.compared < enough || come.compared < enough) return std::nullopt;
  return std::min(gone.Share(), come.Share());
}

}  // namespace highwall
