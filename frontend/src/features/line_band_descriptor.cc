#include "features/line_band_descriptor.h"

#include <algorithm>
#include <cmath>

namespace highwall::internal {
namespace {

constexpr int kBands = 9;
constexpr int kBandWidth = 7;  // [px]
constexpr int kRows = kBands * kBandWidth;
constexpr int kMaxSamples = 32;  // along the segment; longer ones are sampled more sparsely

// [across > 0, across < 0, along > 0, along < 0]: mean magnitudes along a row.
using RowStatistics = Eigen::Array4f;
// Means, then variances: comparisons are the same as for standard deviations.
using BandStatistics = Eigen::Array<float, 8, 1>;

// gradient_at: returns the gradient at a point (x, y).
template <class Gradient>
RowStatistics SumRow(const Gradient& gradient_at, Eigen::Vector2f p, const Eigen::Vector2f& step,
                     int count, const Eigen::Vector2f& along, const Eigen::Vector2f& across) {
  float across_positive = 0.0F, across_sum = 0.0F, along_positive = 0.0F, along_sum = 0.0F;
  for (int i = 0; i < count; ++i, p += step) {
    const Eigen::Vector2f g = gradient_at(p.x(), p.y());
    const float g_across = across.dot(g), g_along = along.dot(g);
    across_positive += std::max(g_across, 0.0F);
    across_sum += g_across;
    along_positive += std::max(g_along, 0.0F);
    along_sum += g_along;
  }
  return RowStatistics(across_positive, across_positive - across_sum, along_positive,
                       along_positive - along_sum) /
         static_cast<float>(count);
}

// Row weights: a Gaussian over the whole region times one about the centre of the band.
float GlobalWeight(int row) {
  constexpr float kSigma = 0.5F * (kRows - 1);
  const float d = static_cast<float>(row - kRows / 2) / kSigma;
  return std::exp(-0.5F * d * d);
}

float LocalWeight(int distance) {
  const float d = static_cast<float>(distance) / kBandWidth;
  return std::exp(-0.5F * d * d);
}

// Statistics over the rows of a band and its neighbours.
BandStatistics Summarize(const std::array<RowStatistics, kRows>& rows, int band,
                         const std::array<float, 2 * kBandWidth>& local_weights) {
  const int first = std::max(0, (band - 1) * kBandWidth);
  const int end = std::min(kRows, (band + 2) * kBandWidth);
  const int centre = band * kBandWidth + kBandWidth / 2;
  RowStatistics sum = RowStatistics::Zero(), sum_of_squares = RowStatistics::Zero();
  for (int row = first; row < end; ++row) {
    const RowStatistics value = local_weights[static_cast<std::size_t>(std::abs(row - centre))] *
                                rows[static_cast<std::size_t>(row)];
    sum += value;
    sum_of_squares += value * value;
  }
  const float count = static_cast<float>(end - first);
  const RowStatistics mean = sum / count;
  BandStatistics statistics;
  statistics << mean, (sum_of_squares / count - mean * mean).max(0.0F);
  return statistics;
}

// 36 pairs of bands without four distant ones, symmetric about the segment: 32 bytes.
bool IsCompared(int i, int j) {
  return !((i == 0 && (j == 6 || j == 7)) || (j == 8 && (i == 1 || i == 2)));
}

}  // namespace

std::array<std::uint8_t, 32> LineBandDescriptor(const ImageGradient& gradient,
                                                const LineSegment& segment) {
  const float length = segment.Length();
  const Eigen::Vector2f along = (segment.e - segment.s) / length;
  const Eigen::Vector2f across(along.y(), -along.x());
  const int count = std::clamp(static_cast<int>(length), 1, kMaxSamples);
  const Eigen::Vector2f step = (segment.e - segment.s) / static_cast<float>(count);
  const Eigen::Vector2f middle_start = segment.s + 0.5F * step;

  static const auto local_weights = [] {
    std::array<float, 2 * kBandWidth> weights{};
    for (int i = 0; i < 2 * kBandWidth; ++i) weights[static_cast<std::size_t>(i)] = LocalWeight(i);
    return weights;
  }();
  static const auto global_weights = [] {
    std::array<float, kRows> weights{};
    for (int row = 0; row < kRows; ++row) {
      weights[static_cast<std::size_t>(row)] = GlobalWeight(row);
    }
    return weights;
  }();
  const auto anywhere = [&](float x, float y) { return gradient.Nearest(x, y); };
  const auto inside = [&](float x, float y) { return gradient.NearestInside(x, y); };
  const Eigen::Vector2f whole = static_cast<float>(count - 1) * step;
  std::array<RowStatistics, kRows> rows;
  for (int row = 0; row < kRows; ++row) {
    const Eigen::Vector2f start = middle_start + static_cast<float>(row - kRows / 2) * across;
    const bool is_inside = gradient.IsInside(start) && gradient.IsInside(start + whole);
    rows[static_cast<std::size_t>(row)] =
        global_weights[static_cast<std::size_t>(row)] *
        (is_inside ? SumRow(inside, start, step, count, along, across)
                   : SumRow(anywhere, start, step, count, along, across));
  }
  std::array<BandStatistics, kBands> bands;
  for (int band = 0; band < kBands; ++band) {
    bands[static_cast<std::size_t>(band)] = Summarize(rows, band, local_weights);
  }

  std::array<std::uint8_t, 32> descriptor{};
  std::size_t byte = 0;
  for (int i = 0; i < kBands; ++i) {
    for (int j = i + 1; j < kBands; ++j) {
      if (!IsCompared(i, j)) continue;
      const BandStatistics& a = bands[static_cast<std::size_t>(i)];
      const BandStatistics& b = bands[static_cast<std::size_t>(j)];
      unsigned bits = 0;
      for (int k = 0; k < a.size(); ++k) bits = 2 * bits + (a[k] > b[k] ? 1U : 0U);
      descriptor[byte++] = static_cast<std::uint8_t>(bits);
    }
  }
  return descriptor;
}

}  // namespace highwall::internal
