#include "paired_statistics.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include <fmt/core.h>

#include <highwall/core/error.h>

namespace highwall::bench {
namespace {

// Returns P(|t| <= bound), by the finite series for integer degrees of freedom. Source: Abramowitz
// and Stegun, "Handbook of Mathematical Functions", 26.7.3 and 26.7.4.
double StudentProbability(double bound, int degrees_of_freedom) {
  const bool odd = degrees_of_freedom % 2 == 1;
  const double theta = std::atan(bound / std::sqrt(degrees_of_freedom));
  const double squared_cosine = std::cos(theta) * std::cos(theta);
  double term = odd ? std::cos(theta) : 1.0, series = 0.0;
  for (int power = odd ? 1 : 0; power <= degrees_of_freedom - 2; power += 2) {
    series += term;
    term *= squared_cosine * (power + 1) / (power + 2);
  }
  series *= std::sin(theta);
  return odd ? 2.0 / std::numbers::pi * (theta + series) : series;
}

// Sums independent summands; degrees of freedom by Welch and Satterthwaite, none if one of the
// variances is unknown.
MeanLog SumOf(const std::vector<MeanLog>& summands) {
  MeanLog sum;
  double squares = 0.0, degrees_of_freedom = 0.0;
  for (const MeanLog& one : summands) {
    sum.mean += one.mean;
    sum.variance += one.variance;
    degrees_of_freedom += one.degrees_of_freedom;
    if (one.variance > 0.0) squares += one.variance * one.variance / one.degrees_of_freedom;
  }
  const bool known = std::ranges::all_of(
      summands, [](const MeanLog& one) { return one.degrees_of_freedom >= 1.0; });
  if (!known) return sum;
  sum.degrees_of_freedom = squares > 0.0 ? sum.variance * sum.variance / squares  //
                                         : degrees_of_freedom;
  return sum;
}

}  // namespace

double StudentBound(int degrees_of_freedom) {
  HIGHWALL_REQUIRE(degrees_of_freedom >= 1, "degrees of freedom must be at least 1");
  double low = 0.0, high = 13.0;  // 12.7 with one degree of freedom, less with more
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (StudentProbability(middle, degrees_of_freedom) < 0.95 ? low : high) = middle;
  }
  return high;
}

MeanLog MeanOf(const std::vector<double>& logs) {
  HIGHWALL_REQUIRE(!logs.empty(), "the mean of nothing");
  const auto n = static_cast<double>(logs.size());
  MeanLog mean{.mean = std::accumulate(logs.begin(), logs.end(), 0.0) / n,
               .variance = 0.0,
               .degrees_of_freedom = n - 1.0};
  if (logs.size() < 2) return mean;
  for (const double log : logs) mean.variance += (log - mean.mean) * (log - mean.mean);
  mean.variance /= (n - 1.0) * n;
  return mean;
}

MeanLog MeanOfMeans(const std::vector<MeanLog>& means) {
  HIGHWALL_REQUIRE(!means.empty(), "the mean of nothing");
  const auto n = static_cast<double>(means.size());
  std::vector<MeanLog> shares;
  for (const MeanLog& one : means) {
    shares.push_back({one.mean / n, one.variance / (n * n), one.degrees_of_freedom});
  }
  return SumOf(shares);
}

MeanLog DifferenceOf(const MeanLog& a, const MeanLog& b) {
  return SumOf({a, {-b.mean, b.variance, b.degrees_of_freedom}});
}

double Ratio(const MeanLog& mean) {
  return std::exp(mean.mean);
}

std::optional<Interval> RatioInterval(const MeanLog& mean) {
  constexpr double kRounding = 1e-9;  // tolerance for integer degrees of freedom
  if (mean.degrees_of_freedom < 1.0 - kRounding) return std::nullopt;
  // Beyond a thousand degrees of freedom, Student's t is practically Gaussian.
  const int whole = static_cast<int>(std::min(mean.degrees_of_freedom + kRounding, 1000.0));
  const double half = StudentBound(whole) * std::sqrt(mean.variance);
  return Interval{std::exp(mean.mean - half), std::exp(mean.mean + half)};
}

std::string IntervalText(const std::optional<MeanLog>& mean) {
  const std::optional<Interval> interval = mean ? RatioInterval(*mean) : std::nullopt;
  return interval ? fmt::format("{:.3f} to {:.3f}", interval->low, interval->high) : "-";
}

OverSequences Over(const std::vector<MeanLog>& sequences) {
  if (sequences.empty()) return {};
  std::vector<double> logs;
  for (const MeanLog& one : sequences) logs.push_back(one.mean);
  return {sequences.size(), MeanOfMeans(sequences), MeanOf(logs)};
}

}  // namespace highwall::bench
