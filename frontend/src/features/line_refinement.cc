#include "features/line_refinement.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <numeric>
#include <optional>
#include <span>
#include <utility>

#include <Eigen/LU>

namespace highwall::internal {
namespace {

// Returns the unit vector to the bright side of an oriented segment: the left of s -> e with y
// down.
Eigen::Vector2f BrightNormal(const LineSegment& segment) {
  const Eigen::Vector2f d = (segment.e - segment.s).normalized();
  return {d.y(), -d.x()};
}

Eigen::Vector2f PointAt(const LineSegment& segment, float share) {
  return segment.s + share * (segment.e - segment.s);
}

// Edge that fragments are joined to.
class Edge {
 public:
  explicit Edge(const LineSegment& segment)
      : segment_(segment),
        length_(segment.Length()),
        d_((segment.e - segment.s) / length_),
        n_(d_.y(), -d_.x()) {}

  const LineSegment& segment() const { return segment_; }

  // Returns whether a shorter segment is part of the edge.
  bool Continues(const LineSegment& shorter, float max_gap) const {
    constexpr float kMinCosine = 0.9986F;  // 3 degrees, and the same bright side
    constexpr float kMaxOffset = 1.5F;     // [px] of the shorter one's ends
    const Eigen::Vector2f from = shorter.s - segment_.s, to = shorter.e - segment_.s;
    if (std::max(std::abs(n_.dot(from)), std::abs(n_.dot(to))) > kMaxOffset) return false;
    if (d_.dot(shorter.e - shorter.s) < kMinCosine * shorter.Length()) return false;
    return !(d_.dot(from) > length_ + max_gap || d_.dot(to) < -max_gap);
  }

  Edge Joined(const LineSegment& shorter) const {
    LineSegment joined = segment_;
    if (d_.dot(shorter.s - segment_.s) < 0.0F) joined.s = shorter.s;
    if (d_.dot(shorter.e - segment_.s) > length_) joined.e = shorter.e;
    return Edge(joined);
  }

 private:
  LineSegment segment_;
  float length_;
  Eigen::Vector2f d_, n_;
};

// Sorts the longest first; of equal length as they were.
void SortByLength(std::vector<LineSegment>* segments) {
  std::vector<std::pair<float, std::size_t>> order;  // (minus the length, index)
  order.reserve(segments->size());
  for (const LineSegment& segment : *segments) order.emplace_back(-segment.Length(), order.size());
  std::sort(order.begin(), order.end());
  std::vector<LineSegment> sorted;
  sorted.reserve(segments->size());
  for (const auto& [length, index] : order) sorted.push_back((*segments)[index]);
  *segments = std::move(sorted);
}

// Segments by the sector of their direction.
class Directions {
 public:
  explicit Directions(const std::vector<LineSegment>& segments) : sorted_(segments.size()) {
    std::vector<std::size_t> sectors;
    sectors.reserve(segments.size());
    for (const LineSegment& segment : segments) {
      sectors.push_back(SectorOf(segment));
      ++ends_[sectors.back()];
    }
    std::partial_sum(ends_.begin(), ends_.end(), ends_.begin());
    auto next = ends_;  // downwards
    for (std::size_t i = segments.size(); i-- > 0;) sorted_[--next[sectors[i]]] = i;
  }

  // Returns the first segment of those from `begin` on that are within 5 degrees of the direction
  // of a segment, and some others, for which `fits` is true; the number of segments if there is
  // none.
  template <class Predicate>
  std::size_t FindParallel(const LineSegment& segment, std::size_t begin,
                           const Predicate& fits) const {
    std::size_t found = sorted_.size();
    const std::size_t middle = SectorOf(segment);
    for (std::size_t k = 0; k < 3; ++k) {  // the sector and its neighbours
      const std::span<const std::size_t> sector = Sector((middle + kSectors - 1 + k) % kSectors);
      auto i = std::lower_bound(sector.begin(), sector.end(), begin);
      while (i != sector.end() && *i < found && !fits(*i)) ++i;
      if (i != sector.end()) found = std::min(found, *i);
    }
    return found;
  }

 private:
  static constexpr std::size_t kSectors = 64;  // of 5.6 degrees

  static std::size_t SectorOf(const LineSegment& segment) {
    constexpr float kTurn = 2.0F * std::numbers::pi_v<float>;
    const Eigen::Vector2f d = segment.e - segment.s;
    const float share = (std::atan2(d.y(), d.x()) + 0.5F * kTurn) / kTurn;  // of a turn
    return static_cast<std::size_t>(share * kSectors) % kSectors;
  }

  std::span<const std::size_t> Sector(std::size_t sector) const {
    const std::size_t begin = sector > 0 ? ends_[sector - 1] : 0;
    return std::span(sorted_).subspan(begin, ends_[sector] - begin);
  }

  std::vector<std::size_t> sorted_;           // by sector, in each in ascending order
  std::array<std::size_t, kSectors> ends_{};  // of each sector in sorted_
};

// Gradient across an edge at pixels -3 to 3.
constexpr int kProfileReach = 3;
using Profile = std::array<float, 2 * kProfileReach + 1>;

// Returns the position of the peak of a profile by the parabola through it and its neighbours;
// empty if it is weak or at an end.
std::optional<float> Peak(const Profile& profile) {
  constexpr float kMinGradient = 2.0F * ImageGradient::kUnit;  // two grey levels per pixel
  const auto peak = std::max_element(profile.begin() + 1, profile.end() - 1);
  if (*peak < kMinGradient || *peak < peak[-1] || *peak < peak[1]) return std::nullopt;
  const float curvature = peak[-1] - 2.0F * peak[0] + peak[1];
  const float fraction = curvature < 0.0F ? 0.5F * (peak[-1] - peak[1]) / curvature : 0.0F;
  return static_cast<float>(peak - profile.begin() - kProfileReach) + fraction;
}

constexpr int kMinPeaks = 8;
constexpr int kMaxProfiles = 64;

// Offsets from a segment at positions along it, from -1/2 to 1/2.
struct Offsets {
  using Column = Eigen::Array<float, Eigen::Dynamic, 1, Eigen::ColMajor, kMaxProfiles + 1, 1>;
  Column position = Column(kMaxProfiles + 1), offset = Column(kMaxProfiles + 1);  // [], [px]
  int count = 0;
};

// Line offset = a + b t by iteratively reweighted least squares (Cauchy weights of 0.5 px).
struct OffsetLine {
  float a = 0.0F, b = 0.0F;

  float At(float t) const { return a + b * t; }
};

OffsetLine FitOffsets(const Offsets& offsets) {
  constexpr int kIterations = 4;
  constexpr float kScale = 0.5F;
  const auto t = offsets.position.head(offsets.count), offset = offsets.offset.head(offsets.count);
  OffsetLine line;
  for (int i = 0; i < kIterations; ++i) {
    const Offsets::Column residual = (offset - line.a - line.b * t) / kScale;
    const Offsets::Column weight = (1.0F + residual.square()).inverse();
    const Offsets::Column along = weight * t;
    Eigen::Matrix2f A;
    A(0, 0) = weight.sum();
    A(0, 1) = A(1, 0) = along.sum();
    A(1, 1) = (along * t).sum();
    const Eigen::Vector2f y((weight * offset).sum(), (along * offset).sum());
    const Eigen::Vector2f solution = A.inverse() * y;
    line = {solution.x(), solution.y()};
  }
  return line;
}

}  // namespace

LineSegment OrientByGradient(const ImageGradient& gradient, const LineSegment& segment) {
  constexpr int kSamples = 16;
  const Eigen::Vector2f n = BrightNormal(segment);
  float sum = 0.0F;
  for (int i = 0; i < kSamples; ++i) {
    const Eigen::Vector2f p =
        PointAt(segment, (static_cast<float>(i) + 0.5F) / static_cast<float>(kSamples));
    sum += n.dot(gradient.Nearest(p.x(), p.y()));
  }
  return sum >= 0.0F ? segment : LineSegment{segment.e, segment.s};
}

std::vector<LineSegment> MergeCollinear(std::vector<LineSegment> segments, float max_gap) {
  SortByLength(&segments);
  const Directions directions(segments);
  std::vector<bool> is_merged(segments.size(), false);
  for (std::size_t i = 0; i < segments.size(); ++i) {
    if (is_merged[i]) continue;
    Edge edge(segments[i]);
    const auto continues = [&](std::size_t j) {
      return !is_merged[j] && edge.Continues(segments[j], max_gap);
    };
    // The longer edge may reach fragments that were too distant before: the search begins again.
    for (;;) {
      const std::size_t j = directions.FindParallel(edge.segment(), i + 1, continues);
      if (j == segments.size()) break;
      edge = edge.Joined(segments[j]);
      is_merged[j] = true;
    }
    segments[i] = edge.segment();
  }
  std::size_t kept = 0;
  for (std::size_t i = 0; i < segments.size(); ++i) {
    if (!is_merged[i]) segments[kept++] = segments[i];
  }
  segments.resize(kept);
  SortByLength(&segments);
  return segments;
}

LineSegment RefineSegment(const ImageGradient& gradient, const LineSegment& segment) {
  const Eigen::Vector2f n = BrightNormal(segment), d = segment.e - segment.s;
  // Profiles are parts of rows across a steep segment, and of columns across another, so that no
  // interpolation between pixels is needed.
  const int along = std::abs(d.y()) > std::abs(d.x()) ? 1 : 0, across = 1 - along;
  const float low = std::min(segment.s[along], segment.e[along]);
  const float high = std::max(segment.s[along], segment.e[along]);
  const int side = along == 0 ? gradient.width() : gradient.height();
  const int first = std::max(static_cast<int>(std::ceil(low)), 0);
  const int last = std::min(static_cast<int>(high), side - 1);
  const int step =
      last - first < kMaxProfiles / 2 ? 1 : std::max((last - first) / kMaxProfiles + 1, 2);
  const float slope = d[across] / d[along], square = d.squaredNorm();
  Offsets offsets;
  int profiles = 0;
  for (int i = first; i <= last; i += step, ++profiles) {
    const float centre = segment.s[across] + slope * (static_cast<float>(i) - segment.s[along]);
    const int middle = static_cast<int>(centre + 0.5F);
    Profile profile;
    for (int k = 0; k < static_cast<int>(profile.size()); ++k) {
      const int j = middle + k - kProfileReach;
      profile[static_cast<std::size_t>(k)] =
          n.dot(along == 0 ? gradient.At(i, j) : gradient.At(j, i));
    }
    const auto peak = Peak(profile);
    if (!peak) continue;
    // The peak is off the segment by its distance from the line.
    Eigen::Vector2f p;
    p[along] = static_cast<float>(i);
    p[across] = static_cast<float>(middle) + *peak;
    offsets.position[offsets.count] = d.dot(p - segment.s) / square - 0.5F;
    offsets.offset[offsets.count++] = n[across] * (p[across] - centre);
  }
  if (offsets.count < std::max(kMinPeaks, profiles / 2)) return segment;
  const OffsetLine line = FitOffsets(offsets);
  constexpr float kMaxShift = 2.0F;  // [px] beyond it the fit has left the edge
  const float at_s = line.At(-0.5F), at_e = line.At(0.5F);
  if (!(std::max(std::abs(at_s), std::abs(at_e)) < kMaxShift)) return segment;
  return {segment.s + at_s * n, segment.e + at_e * n};
}

}  // namespace highwall::internal
