#include "pose/landmark_motion.h"

#include <algorithm>
#include <optional>

#include <Eigen/Cholesky>

#include <highwall/core/error.h>

#include "pose/support.h"

namespace highwall {

bool HaveMoved(const Pose& T_WC, const RgbdProjection& projection,
               std::span<const PosePoint> judged, int judged_lines,
               const PerKind<PoseObservations>& others, const LandmarkMotionOptions& options) {
  // Sigma of directions unobservable from the others: any motion along them is consistent.
  constexpr double kOpen = 30.0;  // [m, rad]
  constexpr double kLeastError = 0.2;
  // Of an inconsistent point, in units of the noise of the others: 99.999 % with 3 rows, since
  // errors of landmarks on one surface are correlated.
  constexpr double kMinChi2 = 25.9;
  constexpr int kMinSupportOfOthers = 20;  // PoseSolverOptions
  if (static_cast<int>(judged.size()) < options.min_points) return false;
  const int of_judged = Support(static_cast<int>(judged.size()), judged_lines);
  // Not even if all others support the pose.
  const auto most = static_cast<int>(SupportOf(others));
  if (most < options.outnumber * of_judged) return false;
  PoseSolverOptions of_others;
  of_others.min_support = kMinSupportOfOthers;
  const auto solution = SolvePose(T_WC, projection, others, of_others);
  const int support = solution ? Support(solution->num_points, solution->num_lines) : 0;
  if (!solution || support < options.outnumber * of_judged) return false;

  Eigen::Matrix<double, 6, 6> information = solution->information;
  information.diagonal().array() += 1.0 / (kOpen * kOpen);
  const Eigen::Matrix<double, 6, 6> covariance =
      information.ldlt().solve(Eigen::Matrix<double, 6, 6>::Identity());
  const double noise = std::max(kLeastError, solution->error);  // relative variance
  const RgbdProjection::View view = RgbdProjection::At(solution->T_WC.data());
  int evaluated = 0, contradict = 0;
  for (const PosePoint& point : judged) {
    Eigen::Vector3d r;
    Eigen::Matrix<double, 3, 6> J;
    if (!projection.Evaluate<3>(view, point.rows, point.p_W, &r, &J, nullptr)) continue;
    const Eigen::Matrix3d S = Eigen::Matrix3d::Identity() + J * covariance * J.transpose();
    ++evaluated;
    contradict += r.dot(S.ldlt().solve(r)) > kMinChi2 * noise ? 1 : 0;
  }
  return contradict >= options.min_points && contradict >= options.min_share * evaluated;
}

}  // namespace highwall
