#include "map/epipolar_matcher.h"

#include <cmath>
#include <cstddef>
#include <optional>

#include <highwall/core/so3.h>
#include <highwall/frontend/features/orb_matcher.h>
#include <highwall/internal/target_clones.h>

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

// The corners of b to be matched, as arrays for DistancesToLine().
struct Candidates {
  std::vector<int> indices, octaves;
  std::vector<double> u, v, sigmas;  // [px]
};

Candidates CandidatesOf(const MeasurementModel& model, const EpipolarView& view) {
  Candidates candidates;
  for (std::size_t j = 0; j < view.wanted.size(); ++j) {
    if (!view.wanted[j]) continue;
    const PointFeature& feature = view.features.points[j];
    candidates.indices.push_back(static_cast<int>(j));
    candidates.octaves.push_back(feature.octave);
    candidates.u.push_back(feature.uv.x());
    candidates.v.push_back(feature.uv.y());
    candidates.sigmas.push_back(model.PointSigma(feature));
  }
  return candidates;
}

// Computes the distances [px] from a line to corners.
HIGHWALL_TARGET_CLONES("avx2", "default")
void DistancesToLine(const double* line, const double* __restrict u, const double* __restrict v,
                     std::size_t count, double* __restrict distances) {
  const double a = line[0], b = line[1], c = line[2];
  for (std::size_t j = 0; j < count; ++j) distances[j] = std::abs(a * u[j] + b * v[j] + c);
}

}  // namespace

std::vector<std::pair<int, int>> MatchEpipolar(const MeasurementModel& model, const EpipolarView& a,
                                               const EpipolarView& b,
                                               const EpipolarMatchOptions& options) {
  const Pose T_BA = b.T_WC.Inverse() * a.T_WC;
  if (T_BA.p().norm() < kNoBaseline) return {};
  const EpipolarLines lines(model.camera(), T_BA);
  const double bound = std::sqrt(options.chi2);
  const Candidates candidates = CandidatesOf(model, b);
  std::vector<double> distances(candidates.indices.size());
  BestPairs pairs(b.wanted.size());
  for (std::size_t i = 0; i < a.wanted.size(); ++i) {
    if (!a.wanted[i]) continue;
    const PointFeature& from = a.features.points[i];
    const auto line = lines.Of(from.uv);
    if (!line) continue;
    const std::uint8_t* descriptor = a.features.point_descriptors.ptr(static_cast<int>(i));
    BestPartner best;
    const double sigma = model.PointSigma(from);
    DistancesToLine(line->data(), candidates.u.data(), candidates.v.data(), distances.size(),
                    distances.data());
    for (std::size_t j = 0; j < distances.size(); ++j) {
      // The root of the sum of squares is below the sum: this test rejects most without it.
      if (distances[j] > bound * (sigma + candidates.sigmas[j])) continue;
      if (distances[j] > bound * std::hypot(sigma, candidates.sigmas[j])) continue;
      if (std::abs(candidates.octaves[j] - from.octave) > 1) continue;
      const int index = candidates.indices[j];
      best.Offer(index, HammingDistance(descriptor, b.features.point_descriptors.ptr(index)));
    }
    if (best.IsClear(options.max_hamming, options.ratio)) pairs.Take(static_cast<int>(i), best);
  }
  return pairs.Pairs();
}

}  // namespace highwall
