#include "map/epipolar_matcher.h"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
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

// Corners that are near a line are marked in words of eight, most of which are empty.
using Word = std::uint64_t;
constexpr float kRounding = 0.01F;  // [px] more than single precision loses in an image

// The corners of b to be matched. In single precision as arrays for MarkNearLine(), which only
// preselects; `reach` is their share of the bound on the distance.
struct Candidates {
  std::vector<int> indices, octaves;
  std::vector<double> sigmas;  // [px]
  std::vector<float> u, v, reach;
};

Candidates CandidatesOf(const MeasurementModel& model, const EpipolarView& view, double bound) {
  Candidates candidates;
  for (std::size_t j = 0; j < view.wanted.size(); ++j) {
    if (!view.wanted[j]) continue;
    const PointFeature& feature = view.features.points[j];
    const double sigma = model.PointSigma(feature);
    candidates.indices.push_back(static_cast<int>(j));
    candidates.octaves.push_back(feature.octave);
    candidates.sigmas.push_back(sigma);
    candidates.u.push_back(static_cast<float>(feature.uv.x()));
    candidates.v.push_back(static_cast<float>(feature.uv.y()));
    candidates.reach.push_back(static_cast<float>(bound * sigma) + kRounding);
  }
  return candidates;
}

// Marks the corners whose distance from the line exceeds their reach by at most `limit`.
HIGHWALL_TARGET_CLONES("avx2", "default")
void MarkNearLine(const float* line, float limit, const float* __restrict u,
                  const float* __restrict v, const float* __restrict reach, std::size_t count,
                  std::uint8_t* __restrict near) {
  const float a = line[0], b = line[1], c = line[2];
  for (std::size_t j = 0; j < count; ++j) {
    near[j] = std::abs(a * u[j] + b * v[j] + c) <= limit + reach[j] ? 1 : 0;
  }
}

}  // namespace

std::vector<std::pair<int, int>> MatchEpipolar(const MeasurementModel& model, const EpipolarView& a,
                                               const EpipolarView& b,
                                               const EpipolarMatchOptions& options) {
  const Pose T_BA = b.T_WC.Inverse() * a.T_WC;
  if (T_BA.p().norm() < kNoBaseline) return {};
  const EpipolarLines lines(model.camera(), T_BA);
  const double bound = std::sqrt(options.chi2);
  const Candidates candidates = CandidatesOf(model, b, bound);
  const std::size_t count = candidates.indices.size();
  std::vector<std::uint8_t> near(count + sizeof(Word), 0);
  BestPairs pairs(b.wanted.size());
  for (std::size_t i = 0; i < a.wanted.size(); ++i) {
    if (!a.wanted[i]) continue;
    const PointFeature& from = a.features.points[i];
    const auto line = lines.Of(from.uv);
    if (!line) continue;
    const double sigma = model.PointSigma(from);
    const Eigen::Vector3f rough = line->cast<float>();
    MarkNearLine(rough.data(), static_cast<float>(bound * sigma), candidates.u.data(),
                 candidates.v.data(), candidates.reach.data(), count, near.data());
    const std::uint8_t* descriptor = a.features.point_descriptors.ptr(static_cast<int>(i));
    BestPartner best;
    const auto offer = [&](std::size_t j) {
      const int index = candidates.indices[j];
      const Eigen::Vector2d& uv = b.features.points[static_cast<std::size_t>(index)].uv;
      const double distance = std::abs(line->x() * uv.x() + line->y() * uv.y() + line->z());
      if (distance > bound * std::hypot(sigma, candidates.sigmas[j])) return;
      if (std::abs(candidates.octaves[j] - from.octave) > 1) return;
      best.Offer(index, HammingDistance(descriptor, b.features.point_descriptors.ptr(index)));
    };
    for (std::size_t first = 0; first < count; first += sizeof(Word)) {
      Word any = 0;
      std::memcpy(&any, &near[first], sizeof(any));
      if (any == 0) continue;
      for (std::size_t j = first; j < first + sizeof(Word); ++j) {
        if (near[j] != 0) offer(j);
      }
    }
    if (best.IsClear(options.max_hamming, options.ratio)) pairs.Take(static_cast<int>(i), best);
  }
  return pairs.Pairs();
}

}  // namespace highwall
