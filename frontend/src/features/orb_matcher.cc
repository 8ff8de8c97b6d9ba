#include <highwall/frontend/features/orb_matcher.h>

#include <bit>
#include <cstring>

#include <highwall/core/error.h>
#include <highwall/internal/target_clones.h>

namespace highwall {
namespace {

constexpr int kDescriptorBytes = 32;
constexpr int kDescriptorBits = 8 * kDescriptorBytes;

// Inlined into functions with clones, where it becomes four popcnt instructions.
[[gnu::always_inline]] inline int CountDifferentBits(const std::uint8_t* a, const std::uint8_t* b) {
  int count = 0;
  for (std::size_t i = 0; i < kDescriptorBytes; i += sizeof(std::uint64_t)) {
    std::uint64_t x, y;
    std::memcpy(&x, a + i, sizeof(x));
    std::memcpy(&y, b + i, sizeof(y));
    count += std::popcount(x ^ y);
  }
  return count;
}

HIGHWALL_TARGET_CLONES("popcnt", "default")
void DistancesToAll(const std::uint8_t* query, const std::uint8_t* train, std::size_t stride,
                    int count, int* distances) {
  for (int i = 0; i < count; ++i, train += stride) distances[i] = CountDifferentBits(query, train);
}

void RequireDescriptors(const cv::Mat& descriptors) {
  HIGHWALL_REQUIRE(descriptors.empty() || (descriptors.dims == 2 && descriptors.type() == CV_8UC1 &&
                                           descriptors.cols == kDescriptorBytes),
                   "MatchDescriptors: descriptors must be CV_8U with 32 columns");
}

struct Best {
  int index = -1;
  int distance = kDescriptorBits + 1;
  int second_distance = kDescriptorBits + 1;

  void Offer(int candidate, int d) {
    if (d < distance) {
      second_distance = distance;
      distance = d;
      index = candidate;
    } else if (d < second_distance) {
      second_distance = d;
    }
  }
};

}  // namespace

HIGHWALL_TARGET_CLONES("popcnt", "default")
int HammingDistance(const std::uint8_t* a, const std::uint8_t* b) {
  return CountDifferentBits(a, b);
}

void OrbMatcherOptions::Validate() const {
  HIGHWALL_REQUIRE(max_distance >= 0 && max_distance <= kDescriptorBits,
                   "OrbMatcherOptions::max_distance must be in [0, 256]");
  HIGHWALL_REQUIRE(ratio > 0.0 && ratio <= 1.0, "OrbMatcherOptions::ratio must be in (0, 1]");
}

std::vector<FeatureMatch> MatchDescriptors(const cv::Mat& query, const cv::Mat& train,
                                           const OrbMatcherOptions& options) {
  options.Validate();
  RequireDescriptors(query);
  RequireDescriptors(train);
  std::vector<Best> best_of_query(static_cast<std::size_t>(query.rows));
  std::vector<Best> best_of_train(static_cast<std::size_t>(train.rows));
  std::vector<int> distances(best_of_train.size());
  for (int i = 0; i < query.rows && train.rows > 0; ++i) {
    DistancesToAll(query.ptr<std::uint8_t>(i), train.ptr<std::uint8_t>(), train.step[0], train.rows,
                   distances.data());
    for (int j = 0; j < train.rows; ++j) {
      const int distance = distances[static_cast<std::size_t>(j)];
      best_of_query[static_cast<std::size_t>(i)].Offer(j, distance);
      best_of_train[static_cast<std::size_t>(j)].Offer(i, distance);
    }
  }
  std::vector<FeatureMatch> matches;
  for (int i = 0; i < query.rows; ++i) {
    const Best& best = best_of_query[static_cast<std::size_t>(i)];
    if (best.index < 0 || best.distance > options.max_distance) continue;
    if (options.ratio < 1.0 && best.distance >= options.ratio * best.second_distance) continue;
    if (options.mutual && best_of_train[static_cast<std::size_t>(best.index)].index != i) continue;
    matches.push_back({i, best.index, best.distance});
  }
  return matches;
}

}  // namespace highwall
