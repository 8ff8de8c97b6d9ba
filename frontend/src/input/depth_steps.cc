#include "input/depth_steps.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>
#include <functional>
#include <numbers>
#include <vector>

namespace highwall {
namespace {

// Values are analysed in bands: a distribution that is smooth across a band, such as the share of
// the scene at each depth, has no effect at the spacings that are searched.
constexpr double kBandRatio = 1.2;
constexpr double kMinPeriods = 8.0;      // spacings in a band
constexpr double kNyquist = 2.2;         // stored units per spacing
constexpr double kMinReadings = 2000.0;  // in a band
// distinct values in a band: fewer fit some spacing by chance
constexpr std::size_t kMinValues = 8;
// Of an accepted spacing. By chance a band of n distinct values has 1 / sqrt(n), below 0.2.
constexpr double kMinCoherence = 0.3;
// A sharp comb is as coherent at a half and a third of its spacing: the largest spacing with this
// share of the best coherence is chosen.
constexpr double kFundamental = 0.75;

struct Band {
  double low = 0.0, high = 0.0;  // [stored units]
  std::vector<double> values{}, weights{};
  double readings = 0.0;
};

std::vector<Band> Bands(DepthHistogram histogram) {
  std::vector<Band> bands;
  const auto size = static_cast<double>(histogram.size());
  for (double low = 50.0; low < size; low *= kBandRatio) {
    Band band{.low = low, .high = std::min(size, low * kBandRatio)};
    for (auto value = static_cast<std::size_t>(std::ceil(band.low));
         static_cast<double>(value) < band.high; ++value) {
      if (histogram[value] == 0) continue;
      const double v = static_cast<double>(value);
      const double window = std::sin(std::numbers::pi * (v - low) / (band.high - low));
      band.values.push_back(v);
      band.weights.push_back(window * window * static_cast<double>(histogram[value]));
      band.readings += static_cast<double>(histogram[value]);
    }
    if (band.readings < kMinReadings || band.values.size() < kMinValues) continue;
    bands.push_back(std::move(band));
  }
  return bands;
}

// phase(value): in cycles.
double Coherence(const Band& band, const std::function<double(double)>& phase) {
  std::complex<double> sum = 0.0;
  double weight = 0.0;
  for (std::size_t i = 0; i < band.values.size(); ++i) {
    sum += std::polar(band.weights[i], 2.0 * std::numbers::pi * phase(band.values[i]));
    weight += band.weights[i];
  }
  return weight > 0.0 ? std::abs(sum) / weight : 0.0;
}

// Finds the largest of the spacings first, first * ratio, ..., on which the bands agree.
// periods(band, spacing): number of periods in the band, 0 if rounding hides them.
std::optional<DepthSteps> Search(const std::vector<Band>& bands, double first, double last,
                                 double ratio,
                                 const std::function<double(const Band&, double)>& periods,
                                 const std::function<double(double value, double spacing)>& phase) {
  std::vector<DepthSteps> found;
  DepthSteps best;
  for (double spacing = first; spacing < last; spacing *= ratio) {
    double sum = 0.0, weight = 0.0;
    for (const Band& band : bands) {
      if (periods(band, spacing) < kMinPeriods) continue;
      // The square root prevents a single wall from dominating.
      const double share = std::sqrt(band.readings);
      sum += share * Coherence(band, [&](double value) { return phase(value, spacing); });
      weight += share;
    }
    if (weight == 0.0) continue;
    found.push_back({spacing, sum / weight});
    if (found.back().coherence > best.coherence) best = found.back();
  }
  if (best.coherence < kMinCoherence) return std::nullopt;
  for (auto it = found.rbegin(); it != found.rend(); ++it) {
    if (it->coherence < std::max(kMinCoherence, kFundamental * best.coherence)) continue;
    while (std::next(it) != found.rend() && std::next(it)->coherence > it->coherence) ++it;
    return *it;
  }
  return best;
}

}  // namespace

std::optional<DepthSteps> FindInverseSteps(DepthHistogram histogram) {
  // [1/stored unit] From 1/32 px of 60 px m at 5000 units per metre to 1/8 px of 20 px m at 1000.
  constexpr double kFirst = 5e-8, kLast = 1e-5, kRatio = 1.002;
  const auto periods = [](const Band& band, double spacing) {
    if (spacing * band.low * band.low < kNyquist) return 0.0;
    return (1.0 / band.low - 1.0 / band.high) / spacing;
  };
  return Search(Bands(histogram), kFirst, kLast, kRatio, periods,
                [](double value, double spacing) { return 1.0 / (value * spacing); });
}

std::optional<DepthSteps> FindUnit(DepthHistogram histogram) {
  constexpr double kFirst = kNyquist, kLast = 12.0, kRatio = 1.0005;
  constexpr double kFilled = 1.0 / 3.0;  // of the multiples: with fewer, some spacing always fits
  const auto filled = [](const Band& band, double spacing) {
    return static_cast<double>(band.values.size()) * spacing >= kFilled * (band.high - band.low);
  };
  const auto periods = [&](const Band& band, double spacing) {
    return filled(band, spacing) ? (band.high - band.low) / spacing : 0.0;
  };
  const std::vector<Band> bands = Bands(histogram);
  if (const auto unit = Search(bands, kFirst, kLast, kRatio, periods,
                               [](double value, double spacing) { return value / spacing; })) {
    return unit;
  }
  const bool any = std::ranges::any_of(bands, [&](const Band& band) { return filled(band, 1.0); });
  return any ? std::optional(DepthSteps{1.0, 1.0}) : std::nullopt;
}

}  // namespace highwall
