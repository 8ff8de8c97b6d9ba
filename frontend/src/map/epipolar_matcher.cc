#include "map/epipolar_matcher.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>

#include "features/orb_matcher.h"
#include "map/best_pairs.h"

namespace highwall {
namespace {

constexpr double kNoBaseline = 1e-6;  // [m]

// The line in b's image [px], of unit normal, on which what is along the ray of `uv` is seen.
class EpipolarLines {
 public:
  EpipolarLines(const PinholeCamera& camera, const Pose& T_BA) : camera_(camera) {
    const Eigen::Vector3d t = T_BA.p();
    Eigen::Matrix3d across;
    across << 0.0, -t.z(), t.y(), t.z(), 0.0, -t.x(), -t.y(), t.x(), 0.0;
    essential_ = across * T_BA.R();
  }

  // Empty where the ray goes through b's camera.
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
  Eigen::Matrix3d essential_;
};

}  // namespace

std::vector<std::pair<int, int>> MatchEpipolar(const MeasurementModel& model, const EpipolarView& a,
                                               const EpipolarView& b,
                                               const EpipolarMatchOptions& options) {
  const Pose T_BA = b.T_WC.Inverse() * a.T_WC;
  if (T_BA.p().norm() < kNoBaseline) return {};
  const EpipolarLines lines(model.camera(), T_BA);
  const double bound = std::sqrt(options.chi2);
  std::vector<int> candidates;
  for (std::size_t j = 0; j < b.wanted.size(); ++j) {
    if (b.wanted[j]) candidates.push_back(static_cast<int>(j));
  }
  BestPairs pairs(b.wanted.size());
  for (std::size_t i = 0; i < a.wanted.size(); ++i) {
    if (!a.wanted[i]) continue;
    const PointFeature& from = a.features.points[i];
    const auto line = lines.Of(from.uv);
    if (!line) continue;
    const std::uint8_t* descriptor = a.features.point_descriptors.ptr(static_cast<int>(i));
    BestPartner best;
    for (const int j : candidates) {
      const PointFeature& to = b.features.points[static_cast<std::size_t>(j)];
      if (std::abs(to.octave - from.octave) > 1) continue;
      const double distance = std::abs(line->head<2>().dot(to.uv) + line->z());
      const double sigma = std::hypot(model.PointSigma(from), model.PointSigma(to));
      if (distance > bound * sigma) continue;
      best.Offer(j, HammingDistance(descriptor, b.features.point_descriptors.ptr(j)));
    }
    if (best.IsClear(options.max_hamming, options.ratio)) pairs.Take(static_cast<int>(i), best);
  }
  return pairs.Pairs();
}

}  // namespace highwall
