#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

// Statistics of ratios measured in pairs: means of the logarithm, and their confidence intervals.
namespace highwall::bench {

// Returns half the width of the interval that contains 95 % of Student's t distribution with that
// many degrees of freedom, at least 1.
double StudentBound(int degrees_of_freedom);

// Mean of logarithms of ratios, with its uncertainty.
struct MeanLog {
  double mean = 0.0;
  double variance = 0.0;            // of the mean
  double degrees_of_freedom = 0.0;  // of the variance; below 1 it is unknown
};

// Returns the mean of independent samples of one distribution. logs: not empty.
MeanLog MeanOf(const std::vector<double>& logs);

// Returns the unweighted mean of means with different variances; its degrees of freedom are those
// of Welch and Satterthwaite, none if one of the variances is unknown. means: not empty.
MeanLog MeanOfMeans(const std::vector<MeanLog>& means);

// Returns a - b of independent means, with degrees of freedom as above.
MeanLog DifferenceOf(const MeanLog& a, const MeanLog& b);

struct Interval {
  double low = 0.0, high = 0.0;
};

// Returns exp(mean).
double Ratio(const MeanLog& mean);
// Returns the 95 % confidence interval of the true ratio, by Student's t with the degrees of
// freedom rounded down; empty below one degree of freedom.
std::optional<Interval> RatioInterval(const MeanLog& mean);
// Returns a text such as "0.912 to 1.034"; "-" if there is no interval.
std::string IntervalText(const std::optional<MeanLog>& mean);

// Mean ratio of several sequences with equal weights; empty if there are none.
struct OverSequences {
  std::size_t sequences = 0;
  std::optional<MeanLog> these;  // uncertainty from those of the sequences
  std::optional<MeanLog> such;   // uncertainty from their scatter: for another sequence
};
OverSequences Over(const std::vector<MeanLog>& sequences);

}  // namespace highwall::bench
