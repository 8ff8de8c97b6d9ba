#include "map/epipolar_line_matcher.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>

#include <Eigen/Geometry>

#include <highwall/frontend/features/orb_matcher.h>

#include "map/best_pairs.h"

namespace highwall {
namespace {

constexpr double kMinOverlap = 0.5;  // of the shorter of the two observed pieces of a line

// A segment of b: its direction, and its line as a row on (u, v, 1) [px].
struct ImageLine {
  ImageLine(const LineSegment& segment, double sigma_px)
      : s(segment.s.cast<double>()),
        length(static_cast<double>(segment.Length())),
        sigma(sigma_px) {
    along = (segment.e.cast<double>() - s) / length;
    across = {-along.y(), along.x(), along.y() * s.x() - along.x() * s.y()};
  }
  Eigen::Vector2d s;
  double length, sigma;
  Eigen::Vector2d along;
  Eigen::Vector3d across;
};

// Epipolar paths of the ends of a's segments in b, from infinite depth to min_depth.
class EndWays {
 public:
  EndWays(const MeasurementModel& model, const Pose& T_BA) : camera_(model.camera()) {
    K_ << camera_.fx, 0.0, camera_.cx, 0.0, camera_.fy, camera_.cy, 0.0, 0.0, 1.0;
    KR_ = K_ * T_BA.R();
    shift_ = K_ * T_BA.p() / model.projection().min_depth();
  }

  // Returns where b's line crosses the path [px along the line]; empty if it does not come within
  // bound [px], or is parallel to the path.
  std::optional<double> Crossing(const Eigen::Vector2f& end, const ImageLine& line,
                                 double bound) const {
    const Eigen::Vector3d far = KR_ * camera_.Unproject(end.cast<double>(), 1.0);
    const double at_far = line.across.dot(far), change = line.across.dot(shift_);
    if (std::abs(change) <= bound) return std::nullopt;
    const double share = std::clamp(-at_far / change, 0.0, 1.0);  // of the largest inverse depth
    const Eigen::Vector3d seen = far + share * shift_;
    if (!(seen.z() > 0.0)) return std::nullopt;
    if (std::abs(line.across.dot(seen)) > bound * seen.z()) return std::nullopt;
    return line.along.dot(seen.head<2>() / seen.z() - line.s);
  }

 private:
  const PinholeCamera& camera_;
  Eigen::Matrix3d K_, KR_;
  Eigen::Vector3d shift_;
};

// Returns whether the segment of a may be part of b's line.
bool MayBeOne(const EndWays& ways, const LineSegment& a, const ImageLine& b, double bound) {
  const auto s = ways.Crossing(a.s, b, bound), e = ways.Crossing(a.e, b, bound);
  if (!s || !e || *e <= *s) return false;
  const double overlap = std::min(*e, b.length) - std::max(*s, 0.0);
  return overlap >= kMinOverlap * std::min(*e - *s, b.length);
}

}  // namespace

std::vector<std::pair<int, int>> MatchEpipolarLines(const MeasurementModel& model,
                                                    const EpipolarView& a, const EpipolarView& b,
                                                    double chi2) {
  const Pose T_BA = b.T_WC.Inverse() * a.T_WC;
  if (T_BA.p().norm() < kNoBaseline) return {};
  const cv::Mat &descriptors_a = a.features.line_descriptors,
                &descriptors_b = b.features.line_descriptors;
  if (descriptors_a.empty() || descriptors_b.empty()) return {};
  const LineMatcherOptions& options = model.matching().lines;
  const EndWays ways(model, T_BA);
  std::vector<std::pair<int, ImageLine>> candidates;
  for (std::size_t j = 0; j < b.wanted.size(); ++j) {
    if (!b.wanted[j]) continue;
    const LineFeature& line = b.features.lines[j];
    candidates.emplace_back(static_cast<int>(j), ImageLine(line.segment, model.LineSigma(line)));
  }
  BestPairs pairs(b.wanted.size());
  for (std::size_t i = 0; i < a.wanted.size(); ++i) {
    if (!a.wanted[i]) continue;
    const LineFeature& from = a.features.lines[i];
    const double variance = std::pow(model.LineSigma(from), 2);
    const std::uint8_t* descriptor = descriptors_a.ptr(static_cast<int>(i));
    BestPartner best;
    for (const auto& [j, line] : candidates) {
      const int hamming = HammingDistance(descriptor, descriptors_b.ptr(j));
      if (hamming >= best.second()) continue;
      const double bound = std::sqrt(chi2 * (variance + line.sigma * line.sigma));
      if (MayBeOne(ways, from.segment, line, bound)) best.Offer(j, hamming);
    }
    if (best.IsClear(options.max_distance, options.ratio)) pairs.Take(static_cast<int>(i), best);
  }
  return pairs.Pairs();
}

}  // namespace highwall
