#include "pose/depth_agreement.h"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

namespace highwall {
namespace {

constexpr double kSigmas = 3.0;
constexpr double kRelative = 0.03;  // of the depth: error of a newly estimated pose
constexpr float kMinDepth = 0.05F;  // [m]
constexpr double kMinShare = 0.05;  // of the cells of a grid that must fall on a reading

// Returns the minimum depth of a cell and its neighbours: a point at an edge may be on either side.
cv::Mat Nearest(const cv::Mat& depth) {
  cv::Mat nearest = depth.clone();
  nearest.setTo(1e9F, depth <= 0.0F);
  cv::erode(nearest, nearest, cv::Mat());
  return nearest;
}

}  // namespace

void DepthComparison::Add(const cv::Mat& depth_A, const cv::Mat& depth_B, const Pose& T_AB) {
  if (depth_A.empty() || depth_B.empty()) return;
  a_in_b_ += LookUp(depth_A, depth_B, T_AB.Inverse());
  b_in_a_ += LookUp(depth_B, depth_A, T_AB);
}

void DepthComparison::Add(const DepthComparison& other) {
  a_in_b_ += other.a_in_b_;
  b_in_a_ += other.b_in_a_;
}

DepthComparison::Count DepthComparison::LookUp(const cv::Mat& from, const cv::Mat& onto,
                                               const Pose& T_onto_from) const {
  Count count;
  const Eigen::Matrix3f R = T_onto_from.R().cast<float>();
  const Eigen::Vector3f p = T_onto_from.p().cast<float>();
  const cv::Mat nearest = Nearest(onto);
  for (int v = 0; v < from.rows; ++v) {
    for (int u = 0; u < from.cols; ++u) {
      const float z = from.at<float>(v, u);
      if (z <= 0.0F) continue;
      const Eigen::Vector3f point = R * (z * grid_.Ray({u, v})) + p;
      if (point.z() < kMinDepth) continue;
      const Eigen::Vector2f at = grid_.Project(point);
      const cv::Point cell(static_cast<int>(std::lround(at.x())),
                           static_cast<int>(std::lround(at.y())));
      if (cell.x < 1 || cell.y < 1 || cell.x >= onto.cols - 1 || cell.y >= onto.rows - 1) continue;
      if (onto.at<float>(cell) <= 0.0F) continue;
      ++count.compared;
      const double seen = nearest.at<float>(cell);
      const double margin = kSigmas * M_SQRT2 * noise_.Sigma(seen) + kRelative * seen;
      if (point.z() < seen - margin) ++count.contradict;
    }
  }
  return count;
}

std::optional<double> DepthComparison::Contradiction() const {
  // A small number of cells are mostly edges, where a reading may be of either side.
  const double enough = kMinShare * grid_.camera().width * grid_.camera().height;
  if (a_in_b_.compared < enough || b_in_a_.compared < enough) return std::nullopt;
  return std::min(a_in_b_.Share(), b_in_a_.Share());
}

std::optional<double> DepthContradiction(const cv::Mat& depth, const Pose& T_WC,
                                         std::span<const KeyFrameId> keyframes, const Map& map,
                                         const DepthGrid& grid, const DepthNoise& noise) {
  DepthComparison comparison(grid, noise);
  for (const KeyFrameId id : keyframes) {
    const KeyFrame& keyframe = *map.keyframe(id);
    comparison.Add(depth, keyframe.depth_grid, T_WC.Inverse() * keyframe.T_WC);
  }
  return comparison.Contradiction();
}

}  // namespace highwall
