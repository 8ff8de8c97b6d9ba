#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

// How sure a ratio is that was measured in pairs: means of its logarithm, and their intervals.
namespace highwall::bench {

// Half of the width of the interval that holds 95 % of Student's t with so many degrees of freedom,
// 1 and more.
double StudentBound(int degrees_of_freedom);

// A mean of logarithms of ratios, as well as it is known.
struct MeanLog {
  double mean = 0.0;
  double variance = 0.0;            // of the mean
  double degrees_of_freedom = 0.0;  // of the variance; below 1 nothing is known of it
};

// Of independent samples of one distribution. logs: not empty.
MeanLog MeanOf(const std::vector<double>& logs);

// The plain mean of means that have variances of their own; its degrees of freedom are those of
// Welch and Satterthwaite, none where one of the variances is not known. means: not empty.
MeanLog MeanOfMeans(const std::vector<MeanLog>& means);

// a - b of independent means; its degrees of freedom likewise.
MeanLog DifferenceOf(const MeanLog& a, const MeanLog& b);

struct Interval {
  double low = 0.0, high = 0.0;
};

// exp(mean).
double Ratio(const MeanLog& mean);
// That holds the true ratio in 95 % of the cases, by Student's t with the degrees of freedom
// rounded down; empty below one of them.
std::optional<Interval> RatioInterval(const MeanLog& mean);
// "0.912 to 1.034"; "-" where there is none.
std::string IntervalText(const std::optional<MeanLog>& mean);

// The ratios of several sequences, each with the same weight; empty where there are none.
struct OverSequences {
  std::size_t sequences = 0;
  std::optional<MeanLog> these;  // known as well as those of the sequences are
  std::optional<MeanLog> such;   // as well as they agree: what another sequence would tell
};
OverSequences Over(const std::vector<MeanLog>& sequences);

}  // namespace highwall::bench
