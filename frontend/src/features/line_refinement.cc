#include "features/line_refinement.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

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

// Returns the longer segment merged with the shorter one, or nothing if they are not one edge.
std::optional<LineSegment> Joined(const LineSegment& longer, const LineSegment& shorter,
                                  float max_gap) {
  constexpr float kMinCosine = 0.9986F;  // 3 degrees, and the same bright side
  constexpr float kMaxOffset = 1.5F;     // [px] of the shorter one's ends
  const float length = longer.Length();
  const Eigen::Vector2f d = (longer.e - longer.s) / length;
  const Eigen::Vector2f n(d.y(), -d.x());
  const Eigen::Vector2f from = shorter.s - longer.s, to = shorter.e - longer.s;
  if (std::max(std::abs(n.dot(from)), std::abs(n.dot(to))) > kMaxOffset) return std::nullopt;
  if (d.dot(shorter.e - shorter.s) < kMinCosine * shorter.Length()) return std::nullopt;
  const float first = d.dot(from), last = d.dot(to);
  if (first > length + max_gap || last < -max_gap) return std::nullopt;
  LineSegment joined = longer;
  if (first < 0.0F) joined.s = shorter.s;
  if (last > length) joined.e = shorter.e;
  return joined;
}

// Offset [px] along n of the peak of the gradient component along n, within two pixels of p.
std::optional<float> GradientPeak(const ImageGradient& gradient, const Eigen::Vector2f& p,
                                  const Eigen::Vector2f& n) {
  constexpr int kReach = 2;
  constexpr float kMinGradient = 16.0F;  // two grey levels per pixel
  std::array<float, 2 * kReach + 3> profile;
  for (int i = 0; i < static_cast<int>(profile.size()); ++i) {
    const Eigen::Vector2f q = p + static_cast<float>(i - kReach - 1) * n;
    profile[static_cast<std::size_t>(i)] = n.dot(gradient.At(q));
  }
  const auto peak = std::max_element(profile.begin() + 1, profile.end() - 1);
  if (*peak < kMinGradient || *peak < peak[-1] || *peak < peak[1]) return std::nullopt;
  const float curvature = peak[-1] - 2.0F * peak[0] + peak[1];
  const float fraction = curvature < 0.0F ? 0.5F * (peak[-1] - peak[1]) / curvature : 0.0F;
  return static_cast<float>(peak - profile.begin() - kReach - 1) + fraction;
}

// Line offset = a + b t by iteratively reweighted least squares (Cauchy weights of 0.5 px).
struct OffsetLine {
  float a = 0.0F, b = 0.0F;

  float At(float t) const { return a + b * t; }
};

OffsetLine FitOffsets(const std::vector<Eigen::Vector2f>& samples) {
  constexpr int kIterations = 4;
  constexpr float kScale = 0.5F;
  OffsetLine line;
  for (int i = 0; i < kIterations; ++i) {
    Eigen::Matrix2f A = Eigen::Matrix2f::Zero();
    Eigen::Vector2f y = Eigen::Vector2f::Zero();
    for (const Eigen::Vector2f& sample : samples) {
      const float residual = (sample.y() - line.At(sample.x())) / kScale;
      const float weight = 1.0F / (1.0F + residual * residual);
      const Eigen::Vector2f row(1.0F, sample.x());
      A += weight * row * row.transpose();
      y += weight * sample.y() * row;
    }
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
  const auto longer = [](const LineSegment& a, const LineSegment& b) {
    return a.Length() > b.Length();
  };
  std::stable_sort(segments.begin(), segments.end(), longer);
  for (std::size_t i = 0; i < segments.size(); ++i) {
    for (std::size_t j = i + 1; j < segments.size();) {
      if (const auto joined = Joined(segments[i], segments[j], max_gap)) {
        segments[i] = *joined;
        segments.erase(segments.begin() + static_cast<std::ptrdiff_t>(j));
        j = i + 1;  // the longer line may now reach fragments that were too distant before
      } else {
        ++j;
      }
    }
  }
  std::stable_sort(segments.begin(), segments.end(), longer);
  return segments;
}

LineSegment RefineSegment(const ImageGradient& gradient, const LineSegment& segment) {
  constexpr int kMinPeaks = 8;
  const int count = std::clamp(static_cast<int>(segment.Length() / 2.0F), kMinPeaks, 64);
  const Eigen::Vector2f n = BrightNormal(segment);
  std::vector<Eigen::Vector2f> samples;  // (t in -1/2 .. 1/2, offset)
  samples.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    const float share = (static_cast<float>(i) + 0.5F) / static_cast<float>(count);
    const auto offset = GradientPeak(gradient, PointAt(segment, share), n);
    if (offset) samples.emplace_back(share - 0.5F, *offset);
  }
  if (static_cast<int>(samples.size()) < std::max(kMinPeaks, count / 2)) return segment;
  const OffsetLine line = FitOffsets(samples);
  constexpr float kMaxShift = 2.0F;  // [px] beyond it the fit has left the edge
  const float at_s = line.At(-0.5F), at_e = line.At(0.5F);
  if (!(std::max(std::abs(at_s), std::abs(at_e)) < kMaxShift)) return segment;
  return {segment.s + at_s * n, segment.e + at_e * n};
}

}  // namespace highwall::internal
