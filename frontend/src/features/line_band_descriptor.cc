#include "features/line_band_descriptor.h"

#include <algorithm>
#include <cmath>
#include <span>

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

// Rows are summed several at a time, each in the order of its samples.
constexpr int kLanes = 8;
using Lanes = Eigen::Array<float, kLanes, 1>;

// Gradients at the samples of as many rows as there are lanes.
struct RowSamples {
  std::array<Eigen::Array<int, kLanes, 1>, kMaxSamples> dx, dy;
};

// Reads `count` samples of rows whose first ones lie at (x, y). is_inside: whether all are inside
// of the image.
void ReadRows(const ImageGradient& gradient, Lanes x, Lanes y, const Eigen::Vector2f& step,
              int count, bool is_inside, RowSamples* samples) {
  for (int i = 0; i < count; ++i, x += step.x(), y += step.y()) {
    Eigen::Array<int, kLanes, 1> u = (x + 0.5F).cast<int>(), v = (y + 0.5F).cast<int>();
    if (!is_inside) {
      u = u.max(0).min(gradient.width() - 1);
      v = v.max(0).min(gradient.height() - 1);
    }
    auto& dx = samples->dx[static_cast<std::size_t>(i)];
    auto& dy = samples->dy[static_cast<std::size_t>(i)];
    for (int lane = 0; lane < kLanes; ++lane) {
      const std::int16_t* g = gradient.Row(v[lane]) + 2 * u[lane];
      dx[lane] = g[0];
      dy[lane] = g[1];
    }
  }
}

void SumRows(const RowSamples& samples, int count, const Eigen::Vector2f& along,
             const Eigen::Vector2f& across, std::span<RowStatistics, kLanes> rows) {
  Lanes across_positive = Lanes::Zero(), across_sum = Lanes::Zero();
  Lanes along_positive = Lanes::Zero(), along_sum = Lanes::Zero();
  for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
    const Lanes dx = samples.dx[i].cast<float>(), dy = samples.dy[i].cast<float>();
    const Lanes g_across = across.x() * dx + across.y() * dy;
    const Lanes g_along = along.x() * dx + along.y() * dy;
    across_positive += g_across.max(0.0F);
    across_sum += g_across;
    along_positive += g_along.max(0.0F);
    along_sum += g_along;
  }
  for (int lane = 0; lane < kLanes; ++lane) {
    rows[static_cast<std::size_t>(lane)] =
        RowStatistics(across_positive[lane], across_positive[lane] - across_sum[lane],
                      along_positive[lane], along_positive[lane] - along_sum[lane]) /
        static_cast<float>(count);
  }
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
BandStatistics Summarize(std::span<const RowStatistics> rows, int band,
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
  const Lanes offsets = Lanes::LinSpaced(0.0F, kLanes - 1.0F) - static_cast<float>(kRows / 2);
  const Eigen::Vector2f whole = static_cast<float>(count - 1) * step;
  RowSamples samples;
  std::array<RowStatistics, kRows + (kLanes - kRows % kLanes) % kLanes> rows;
  for (int row = 0; row < kRows; row += kLanes) {
    const Lanes offset = static_cast<float>(row) + offsets;
    const Lanes x = middle_start.x() + offset * across.x();
    const Lanes y = middle_start.y() + offset * across.y();
    const Eigen::Vector2f first(x[0], y[0]), last(x[kLanes - 1], y[kLanes - 1]);
    const bool is_inside = gradient.IsInside(first) && gradient.IsInside(first + whole) &&
                           gradient.IsInside(last) && gradient.IsInside(last + whole);
    ReadRows(gradient, x, y, step, count, is_inside, &samples);
    SumRows(samples, count, along, across,
            std::span(rows).subspan(static_cast<std::size_t>(row)).first<kLanes>());
  }
  for (int row = 0; row < kRows; ++row) {
    rows[static_cast<std::size_t>(row)] *= global_weights[static_cast<std::size_t>(row)];
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
