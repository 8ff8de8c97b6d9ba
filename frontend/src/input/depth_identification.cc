#include <highwall/frontend/input/depth_identification.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>

namespace highwall {
namespace {

// Log-likelihood of a deviation relative to its sigma: half its square, bounded so that no single
// term decides alone, since each can mislead: scenes are chosen, and images are filtered.
double Deviation(double value, double sigma, double most) {
  return -std::min(most, 0.5 * (value / sigma) * (value / sigma));
}

constexpr double kDecisive = 10.0, kStrong = 6.0;

// Prior of the median reading [m]: rooms and tables.
double LogScene(const DepthStatistics& statistics, double factor) {
  constexpr double kTypical = 1.8, kSpread = 0.8;
  return Deviation(std::log(statistics.quantiles[2] / factor / kTypical), kSpread, kStrong);
}

// Penalizes readings outside of the sensor's range.
double LogRange(const DepthStatistics& statistics, const SensorProfile& profile, double factor) {
  const double near = std::max(0.0, std::log(profile.min_depth * factor / statistics.nearest));
  const double far = std::max(0.0, std::log(statistics.farthest / factor / profile.max_depth));
  return Deviation(near + far, 0.15, kStrong);
}

// Drivers round to their unit before the values are scaled.
double LogUnit(const DepthStatistics& statistics, const SensorProfile& profile, double factor) {
  constexpr double kFinest = 2.0;  // [stored units] distinguishable from one
  const double expected = factor / profile.depth_factor;
  if (!statistics.unit) return 0.0;
  if (*statistics.unit > 1.0) {
    return Deviation(std::log(*statistics.unit / expected), 0.02, kStrong);
  }
  return expected >= kFinest ? -2.0 : 0.0;
}

double LogStepsOfMode(double step, const StereoPair& pair, std::size_t mode, double rank_cost) {
  constexpr double kUsual = 0.02;
  const double deviation = std::log(step / pair.InverseDepthStep(pair.focals[mode]));
  return Deviation(deviation, pair.focal_tolerance, kDecisive) -
         std::log(pair.focal_tolerance / kUsual) - rank_cost * static_cast<double>(mode);
}

double LogSteps(const DepthStatistics& statistics, const SensorProfile& profile, double factor) {
  constexpr double kRankCost = 0.25;  // per rank of a mode by how common it is
  const bool triangulates = profile.principle == DepthPrinciple::kTriangulation;
  if (!statistics.inverse_step) {
    if (!triangulates) return 0.0;
    // Filters smear steps; steps that are too fine are lost in the rounding.
    constexpr double kVisible = 3.0, kSmeared = -3.0;
    const double far = statistics.quantiles[4] / factor;
    const double step = profile.pair->InverseDepthStep(profile.pair->focals[0]);
    return step * far * far * factor > kVisible ? kSmeared : 0.0;
  }
  if (!triangulates) return -kDecisive;
  const double step = *statistics.inverse_step * factor;
  double best = -2.0 * kDecisive;
  for (std::size_t mode = 0; mode < profile.pair->focals.size(); ++mode) {
    if (profile.pair->focals[mode] == 0.0) continue;
    best = std::max(best, LogStepsOfMode(step, *profile.pair, mode, kRankCost));
  }
  // The disparities of the nearest readings must lie within the search range.
  const double steps = 1.0 / (statistics.nearest * *statistics.inverse_step);
  const double most = profile.pair->max_disparity / profile.pair->disparity_step;
  return best + Deviation(std::max(0.0, std::log(steps / most)), 0.03, kStrong);
}

// The grain is the noise not shared by neighbouring pixels: a tenth of the noise and more.
double LogGrain(const DepthStatistics& statistics, const SensorProfile& profile, double factor) {
  constexpr double kMost = 1.5, kLeast = 0.05;
  const DepthNoise noise = profile.NoiseFor({.width = statistics.width,
                                             .height = statistics.height,
                                             .fx = static_cast<double>(statistics.width),
                                             .fy = static_cast<double>(statistics.width)});
  double sum = 0.0, count = 0.0, sum_x = 0.0, sum_xx = 0.0, sum_xy = 0.0;
  for (const DepthGrain& grain : statistics.grain) {
    const double depth = grain.depth / factor;
    if (grain.sigma <= 0.0) continue;
    const double x = std::log(depth), y = std::log(grain.sigma / factor / noise.Sigma(depth));
    sum += y;
    sum_x += x;
    sum_xx += x * x;
    sum_xy += x * y;
    ++count;
  }
  if (count == 0.0) return 0.0;
  const double mean = sum / count;
  const double beyond = std::max({0.0, mean - std::log(kMost), std::log(kLeast) - mean});
  double log = Deviation(beyond, 0.5, kStrong);
  const double spread = sum_xx - sum_x * sum_x / count;
  if (count >= 3.0 && spread > 0.3) {
    const double slope = (sum_xy - sum_x * sum / count) / spread;
    log += Deviation(slope, 0.5, kStrong);
  }
  return log;
}

double LogHoles(const DepthStatistics& statistics, const SensorProfile& profile) {
  constexpr double kDense = 0.01;
  const bool dense = statistics.holes < kDense;
  if (dense != profile.dense) return profile.dense ? -4.0 : -1.5;
  const double corners = statistics.corner_holes - statistics.holes;
  if (!profile.round_field) return corners > 0.4 && !profile.pair ? -1.0 : 0.0;
  return corners > 0.2 ? 0.0 : -1.0;
}

// The occlusion shadow of a stereo pair lies on one side of near objects, while the light of a
// time-of-flight camera comes from next to or around its lens.
double LogGaps(const DepthStatistics& statistics, const SensorProfile& profile) {
  constexpr double kOneSide = 0.9;
  const double side = std::max(statistics.left_holes, 1.0 - statistics.left_holes);
  const bool known = statistics.gaps >= 1000;
  return known && side > kOneSide && profile.principle == DepthPrinciple::kTimeOfFlight ? -2.0
                                                                                        : 0.0;
}

bool ShowsSomething(const DepthStatistics& statistics) {
  constexpr double kGrain = 0.1;  // [stored units]; rounding alone makes 0.3
  return statistics.inverse_step ||
         std::ranges::any_of(statistics.grain,
                             [](const DepthGrain& grain) { return grain.sigma > kGrain; });
}

// Any sensor that is none of the others: it may have any steps, grain and holes, which makes it
// less likely than one that has those of the images.
void AddUnknownSensor(const DepthStatistics& statistics, double known_factor,
                      std::vector<DepthGuess>* guesses) {
  constexpr double kUnknown = -4.5;
  const SensorProfile& any = *FindSensorProfile("generic");
  std::vector<double> factors{1000.0, 5000.0};
  if (known_factor > 0.0 && std::ranges::find(factors, known_factor) == factors.end()) {
    factors.push_back(known_factor);
  }
  for (const double factor : factors) {
    guesses->push_back({&any, factor,
                        kUnknown + LogScene(statistics, factor) +
                            LogRange(statistics, any, factor) + LogUnit(statistics, any, factor)});
  }
}

}  // namespace

std::vector<DepthGuess> IdentifyDepthSensor(const DepthStatistics& statistics,
                                            double known_factor) {
  std::vector<DepthGuess> guesses;
  if (!ShowsSomething(statistics)) return guesses;
  for (const SensorProfile& profile : SensorProfiles()) {
    if (profile.principle == DepthPrinciple::kUnknown) continue;
    // The driver's unit, millimetres, and the unit of the TUM RGB-D layout.
    std::vector<double> factors{profile.depth_factor, 1000.0, 5000.0};
    if (factors[0] == factors[1]) factors.erase(factors.begin());
    for (const double factor : factors) {
      const double prior = factor == profile.depth_factor ? 0.0 : -1.0;
      const double log =
          prior + LogScene(statistics, factor) + LogRange(statistics, profile, factor) +
          LogUnit(statistics, profile, factor) + LogSteps(statistics, profile, factor) +
          LogGrain(statistics, profile, factor) + LogHoles(statistics, profile) +
          LogGaps(statistics, profile);
      guesses.push_back({&profile, factor, log});
    }
  }
  AddUnknownSensor(statistics, known_factor, &guesses);
  std::ranges::sort(guesses, std::greater(), &DepthGuess::probability);
  const double best = guesses.front().probability;
  double sum = 0.0;
  for (DepthGuess& guess : guesses) sum += guess.probability = std::exp(guess.probability - best);
  for (DepthGuess& guess : guesses) guess.probability /= sum;
  return guesses;
}

double ProbabilityOfFactor(const std::vector<DepthGuess>& guesses, double depth_factor) {
  constexpr double kSame = 0.06;
  double sum = 0.0;
  for (const DepthGuess& guess : guesses) {
    if (std::abs(guess.depth_factor / depth_factor - 1.0) <= kSame) sum += guess.probability;
  }
  return sum;
}

}  // namespace highwall
