#include <highwall/frontend/features/line_matcher.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>

#include <highwall/core/error.h>

namespace highwall {
namespace {

constexpr double kPi = std::numbers::pi;

double AngleGap(const LineSegment& a, const LineSegment& b) {
  return std::abs(LineAngleDifference(a.Angle(), b.Angle()));
}

double LengthRatio(const LineSegment& a, const LineSegment& b) {
  const float longer = std::max(a.Length(), b.Length());
  return longer > 0.0F ? std::min(a.Length(), b.Length()) / longer : 0.0F;
}

double MidpointDistance(const Eigen::Vector2f& predicted, const LineSegment& b) {
  return (b.Midpoint() - predicted).norm();
}

bool HasDescriptors(const LineFeatures& features) {
  return !features.descriptors.empty();
}

void RequireConsistent(const LineFeatures& features) {
  const cv::Mat& descriptors = features.descriptors;
  HIGHWALL_REQUIRE(
      descriptors.empty() || (descriptors.type() == CV_8UC1 && descriptors.cols == 32 &&
                              descriptors.rows == static_cast<int>(features.segments.size())),
      "line matcher: descriptors must be CV_8U, 32 columns, one row a segment");
}

// A pair within the gates; the fields in sorting order.
struct Candidate {
  double cost;
  int query, train;
  int distance;
};

// Returns every pair that passes the gates and, with descriptors, max_distance; by query.
std::vector<Candidate> FindCandidates(const LineFeatures& query, const LineFeatures& train,
                                      const LineGates& gates, int max_distance,
                                      const std::vector<Eigen::Vector2f>& predicted_midpoints) {
  RequireConsistent(query);
  RequireConsistent(train);
  HIGHWALL_REQUIRE(
      predicted_midpoints.empty() || predicted_midpoints.size() == query.segments.size(),
      "line matcher: one predicted midpoint for each query segment, or none");
  const bool described = HasDescriptors(query) && HasDescriptors(train);
  std::vector<Candidate> candidates;
  for (std::size_t i = 0; i < query.segments.size(); ++i) {
    const LineSegment& a = query.segments[i];
    const Eigen::Vector2f midpoint =
        predicted_midpoints.empty() ? a.Midpoint() : predicted_midpoints[i];
    for (std::size_t j = 0; j < train.segments.size(); ++j) {
      const LineSegment& b = train.segments[j];
      if (!PassesMidpointGate(midpoint, b, gates) || !PassesAngleGate(a, b, gates) ||
          !PassesLengthGate(a, b, gates)) {
        continue;
      }
      Candidate candidate{0.0, static_cast<int>(i), static_cast<int>(j), 0};
      if (described) {
        candidate.distance = HammingDistance(query.descriptors.ptr<std::uint8_t>(candidate.query),
                                             train.descriptors.ptr<std::uint8_t>(candidate.train));
        if (candidate.distance > max_distance) continue;
        candidate.cost = candidate.distance;
      } else {
        candidate.cost = AngleGap(a, b) / gates.max_angle +
                         (1.0 - LengthRatio(a, b)) / (1.0 - gates.min_length_ratio) +
                         MidpointDistance(midpoint, b) / gates.max_midpoint_distance;
      }
      candidates.push_back(candidate);
    }
  }
  return candidates;
}

// Chooses the cheapest first, each segment at most once.
std::vector<FeatureMatch> ChooseOneToOne(std::vector<Candidate> candidates, std::size_t queries,
                                         std::size_t trains) {
  std::sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
    return std::tie(a.cost, a.query, a.train) < std::tie(b.cost, b.query, b.train);
  });
  std::vector<bool> query_used(queries, false), train_used(trains, false);
  std::vector<FeatureMatch> matches;
  for (const Candidate& candidate : candidates) {
    const auto i = static_cast<std::size_t>(candidate.query);
    const auto j = static_cast<std::size_t>(candidate.train);
    if (query_used[i] || train_used[j]) continue;
    query_used[i] = train_used[j] = true;
    matches.push_back({candidate.query, candidate.train, candidate.distance});
  }
  std::sort(matches.begin(), matches.end(),
            [](const FeatureMatch& a, const FeatureMatch& b) { return a.query < b.query; });
  return matches;
}

// Best and second best candidate of one segment.
struct BestTwo {
  const Candidate* best = nullptr;
  const Candidate* second = nullptr;

  void Offer(const Candidate* candidate) {
    if (best == nullptr || candidate->distance < best->distance) {
      second = best;
      best = candidate;
    } else if (second == nullptr || candidate->distance < second->distance) {
      second = candidate;
    }
  }
};

double Median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  if (values.size() % 2 == 1) return *middle;
  return 0.5 * (*middle + *std::max_element(values.begin(), middle));
}

// Returns the absolute deviations of rotations modulo pi from their median.
std::vector<double> DeviationsFromMedian(const std::vector<double>& rotations) {
  // The circular mean determines where the half circle can be cut open.
  double sine = 0.0, cosine = 0.0;
  for (const double phi : rotations) {
    sine += std::sin(2.0 * phi);
    cosine += std::cos(2.0 * phi);
  }
  const double mean = 0.5 * std::atan2(sine, cosine);
  std::vector<double> deviations;
  for (const double phi : rotations) deviations.push_back(LineAngleDifference(phi, mean));
  const double median = Median(deviations);
  for (double& d : deviations) d = std::abs(LineAngleDifference(d, median));
  return deviations;
}

// Direction [rad] of the displacement of the start; the other end of b is used if it is nearer to
// a's start, since detectors may swap ends.
double DisplacementDirection(const LineSegment& a, const LineSegment& b) {
  const bool swapped = (b.e - a.s).squaredNorm() < (b.s - a.s).squaredNorm();
  const Eigen::Vector2f displacement = (swapped ? b.e : b.s) - a.s;
  return std::atan2(displacement.y(), displacement.x());
}

}  // namespace

double LineAngleDifference(double a, double b) {
  const double wrapped = std::remainder(a - b, kPi);
  return wrapped < kPi / 2 ? wrapped : wrapped - kPi;
}

bool PassesAngleGate(const LineSegment& a, const LineSegment& b, const LineGates& gates) {
  return AngleGap(a, b) < gates.max_angle;
}

bool PassesLengthGate(const LineSegment& a, const LineSegment& b, const LineGates& gates) {
  return LengthRatio(a, b) > gates.min_length_ratio;
}

bool PassesMidpointGate(const Eigen::Vector2f& predicted_midpoint, const LineSegment& b,
                        const LineGates& gates) {
  return MidpointDistance(predicted_midpoint, b) < gates.max_midpoint_distance;
}

std::vector<FeatureMatch> MatchSmallMotion(
    const LineFeatures& query, const LineFeatures& train, const LineMatcherOptions& options,
    const std::vector<Eigen::Vector2f>& predicted_midpoints) {
  options.Validate();
  std::vector<Candidate> candidates =
      FindCandidates(query, train, options.small_motion, options.max_distance, predicted_midpoints);
  const std::vector<FeatureMatch> matches =
      ChooseOneToOne(std::move(candidates), query.segments.size(), train.segments.size());
  return RejectByMad(matches, query.segments, train.segments, options);
}

std::vector<FeatureMatch> MatchLargeMotion(
    const LineFeatures& query, const LineFeatures& train, const LineMatcherOptions& options,
    const std::vector<Eigen::Vector2f>& predicted_midpoints) {
  options.Validate();
  for (const LineFeatures* features : {&query, &train}) {
    HIGHWALL_REQUIRE(features->segments.empty() || HasDescriptors(*features),
                     "MatchLargeMotion: line descriptors are needed");
  }
  // Pairs beyond max_distance still count as the second best of the ratio test.
  const std::vector<Candidate> candidates =
      FindCandidates(query, train, options.large_motion, 256, predicted_midpoints);
  std::vector<BestTwo> of_query(query.segments.size()), of_train(train.segments.size());
  for (const Candidate& candidate : candidates) {
    of_query[static_cast<std::size_t>(candidate.query)].Offer(&candidate);
    of_train[static_cast<std::size_t>(candidate.train)].Offer(&candidate);
  }
  std::vector<FeatureMatch> matches;
  for (const BestTwo& two : of_query) {
    if (two.best == nullptr || two.best->distance > options.max_distance) continue;
    if (of_train[static_cast<std::size_t>(two.best->train)].best != two.best) continue;
    if (options.ratio < 1.0 && two.second != nullptr &&
        two.best->distance >= options.ratio * two.second->distance) {
      continue;
    }
    matches.push_back({two.best->query, two.best->train, two.best->distance});
  }
  return RejectByMad(matches, query.segments, train.segments, options);
}

std::vector<FeatureMatch> RejectByMad(const std::vector<FeatureMatch>& matches,
                                      const std::vector<LineSegment>& query,
                                      const std::vector<LineSegment>& train,
                                      const LineMatcherOptions& options) {
  options.Validate();
  if (matches.size() < 3) return matches;
  std::vector<double> phi;
  phi.reserve(matches.size());
  for (const FeatureMatch& match : matches) {
    const LineSegment& a = query.at(static_cast<std::size_t>(match.query));
    const LineSegment& b = train.at(static_cast<std::size_t>(match.train));
    phi.push_back(options.mad_rule == MadRule::kMedian ? LineAngleDifference(b.Angle(), a.Angle())
                                                       : DisplacementDirection(a, b));
  }
  std::vector<double> deviations;
  double limit = 0.0;
  if (options.mad_rule == MadRule::kMedian) {
    deviations = DeviationsFromMedian(phi);
    limit = options.mad_k * std::max(1.4826 * Median(deviations), options.min_deviation);
  } else {
    const auto count = static_cast<double>(phi.size());
    double mean = 0.0, variance = 0.0;
    for (const double x : phi) mean += x / count;
    for (const double x : phi) variance += (x - mean) * (x - mean) / count;
    for (const double x : phi) deviations.push_back(std::abs(x - mean));
    limit = options.mad_k * std::sqrt(variance);
  }
  std::vector<FeatureMatch> kept;
  kept.reserve(matches.size());
  for (std::size_t i = 0; i < matches.size(); ++i) {
    if (deviations[i] <= limit) kept.push_back(matches[i]);
  }
  return kept;
}

}  // namespace highwall
