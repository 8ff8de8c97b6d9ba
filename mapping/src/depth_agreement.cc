#include <cmath>

#include <highwall/internal/require.h>
#include <highwall/mapping/keyframe_cloud.h>

namespace highwall {
namespace {

enum class Vote { kNone, kAgrees, kContradicts };

// Returns the vote of the depth image of camera N on a point p_N.
Vote VoteOf(const cv::Mat& depth, const PinholeCamera& camera, const Eigen::Vector3d& p_N,
            const DepthAgreementOptions& options) {
  if (!(p_N.z() > 0.0)) return Vote::kNone;
  const Eigen::Vector2d uv = camera.Project(p_N);
  if (!camera.Contains(uv)) return Vote::kNone;
  const double z =
      depth.at<float>(static_cast<int>(std::lround(uv.y())), static_cast<int>(std::lround(uv.x())));
  const double tolerance = options.absolute + options.relative * p_N.z();
  if (!(z > 0.0) || z < p_N.z() - tolerance) return Vote::kNone;  // a hole, or occluded
  return z <= p_N.z() + tolerance ? Vote::kAgrees : Vote::kContradicts;
}

}  // namespace

void DepthAgreementOptions::Validate() const {
  RequireNotNegative(absolute, "DepthAgreementOptions::absolute");
  RequireNotNegative(relative, "DepthAgreementOptions::relative");
}

cv::Mat KeepAgreedDepth(const DepthView& view, std::span<const DepthView> neighbours,
                        const PinholeCamera& camera, const DepthUnprojector& unprojector,
                        const DepthAgreementOptions& options) {
  options.Validate();
  unprojector.RequireDepth(view.depth);
  std::vector<Pose> T_NC;
  for (const DepthView& neighbour : neighbours) {
    unprojector.RequireDepth(neighbour.depth);
    T_NC.push_back(neighbour.T_WC.Inverse() * view.T_WC);
  }
  std::vector<Eigen::Matrix3d> R_NC;
  for (const Pose& T : T_NC) R_NC.push_back(T.R());
  cv::Mat kept = view.depth.clone();
  for (int v = 0; v < kept.rows; ++v) {
    for (int u = 0; u < kept.cols; ++u) {
      float& z = kept.at<float>(v, u);
      if (!(z > 0.0f)) continue;
      const Eigen::Vector3d p_C = unprojector.Unproject(u, v, z).cast<double>();
      int agree = 0, contradict = 0;
      for (std::size_t i = 0; i < neighbours.size(); ++i) {
        if (neighbours[i].depth.empty()) continue;
        const Vote vote = VoteOf(neighbours[i].depth, camera, R_NC[i] * p_C + T_NC[i].p(), options);
        agree += vote == Vote::kAgrees;
        contradict += vote == Vote::kContradicts;
      }
      if (contradict > agree || (options.needs_support && agree == 0)) z = 0.0f;
    }
  }
  return kept;
}

}  // namespace highwall
