#include "map/epipolar_matcher.h"

#include <cmath>
#include <cstddef>
#include <optional>

#include <highwall/core/so3.h>
#include <highwall/frontend/features/orb_matcher.h>

#include "map/best_pairs.h"

namespace highwall {
namespace {

// The epipolar line in b's image [px], with unit normal, of the ray of `uv`.
class EpipolarLines {
 public:
  EpipolarLines(const PinholeCamera& camera, const Pose& T_BA)
      : camera_(camera), essential_(so3::Hat(T_BA.p()) * T_BA.R()) {}

  // Empty if the ray passes through b's camera.
  std::optional<Eigen::Vector3d> Of(const Eigen::Vector2d& uv) const {
    const Eigen::Vector3d l = essential_ * camera_.Unproject(uv, 1.0);
    const Eigen::Vector3d line(
        l.x() / camera_.fx, l.y() / camera_.fy,
        l.z() - l.x() * camera_.cx / camera_.fx - l.y() * camera_.cy / camera_.fy);
    const double norm = line.head<2>().norm();
    if (!(norm > 0.0)) return std::nullopt;
    return line / norm;
  }

 private:
  const PinholeCamera& camera_;
  const Eigen::Matrix3d essential_;
};

// A corner of b to be matched.
struct Candidate {
  int index = 0;
  int octave = 0;
  double sigma = 0.0;  // [px]
  Eigen::Vector2d uv;
};

std::vector<Candidate> CandidatesOf(const MeasurementModel& model, const EpipolarView& view) {
  std::vector<Candidate> candidates;
  for (std::size_t j = 0; j < view.wanted.size(); ++j) {
    if (!view.wanted[j]) continue;
    const PointFeature& feature = view.features.points[j];
    candidates.push_back(
        {static_cast<int>(j), feature.octave, model.PointSigma(feature), feature.uv});
  }
  return candidates;
}

}  // namespace

std::vector<std::pair<int, int>> MatchEpipolar(const MeasurementModel& model, const EpipolarView& a,
                                               const EpipolarView& b,
                                               const EpipolarMatchOptions& options) {
  const Pose T_BA = b.T_WC.Inverse() * a.T_WC;
  if (T_BA.p().norm() < kNoBaseline) return {};
  const EpipolarLines lines(model.camera(), T_BA);
  const double bound = std::sqrt(options.chi2);
  const std::vector<Candidate> candidates = CandidatesOf(model, b);
  BestPairs pairs(b.wanted.size());
  for (std::size_t i = 0; i < a.wanted.size(); ++i) {
    if (!a.wanted[i]) continue;
    const PointFeature& from = a.features.points[i];
    const auto line = lines.Of(from.uv);
    if (!line) continue;
    const std::uint8_t* descriptor = a.features.point_descriptors.ptr(static_cast<int>(i));
    BestPartner best;
    const double sigma = model.PointSigma(from);
    for (const Candidate& to : candidates) {
      if (std::abs(to.octave - from.octave) > 1) continue;
      const double distance = std::abs(line->head<2>().dot(to.uv) + line->z());
      // The root of the sum of squares is below the sum: this test rejects most without it.
      if (distance > bound * (sigma + to.sigma)) continue;
      if (distance > bound * std::hypot(sigma, to.sigma)) continue;
      best.Offer(to.index, HammingDistance(descriptor, b.features.point_descriptors.ptr(to.index)));
    }
    if (best.IsClear(options.max_hamming, options.ratio)) pairs.Take(static_cast<int>(i), best);
  }
  return pairs.Pairs();
}

}  // namespace highwall
