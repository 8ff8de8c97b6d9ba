#include <highwall/frontend/features/orb_matcher.h>

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

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
};

Best BestOf(std::span<const int> distances) {
  Best best;
  for (std::size_t j = 0; j < distances.size(); ++j) {
    if (distances[j] >= best.second_distance) continue;  // almost all
    if (distances[j] < best.distance) {
      best = {static_cast<int>(j), distances[j], best.distance};
    } else {
      best.second_distance = distances[j];
    }
  }
  return best;
}

// Offers a query to all descriptors of the other image: the first of the nearest is kept.
HIGHWALL_TARGET_CLONES("avx2", "default")
void OfferToAll(int query, const int* __restrict distances, std::size_t count,
                int* __restrict nearest, int* __restrict queries) {
  for (std::size_t j = 0; j < count; ++j) {
    const bool is_nearer = distances[j] < nearest[j];
    nearest[j] = is_nearer ? distances[j] : nearest[j];
    queries[j] = is_nearer ? query : queries[j];
  }
}

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
  // Of each descriptor of train: the distance to the nearest of query, and which it is.
  std::vector<int> nearest(static_cast<std::size_t>(train.rows), kDescriptorBits + 1);
  std::vector<int> queries(nearest.size(), -1);
  std::vector<int> distances(nearest.size());
  for (int i = 0; i < query.rows && train.rows > 0; ++i) {
    DistancesToAll(query.ptr<std::uint8_t>(i), train.ptr<std::uint8_t>(), train.step[0], train.rows,
                   distances.data());
    best_of_query[static_cast<std::size_t>(i)] = BestOf(distances);
    if (options.mutual) {
      OfferToAll(i, distances.data(), distances.size(), nearest.data(), queries.data());
    }
  }
  std::vector<FeatureMatch> matches;
  for (int i = 0; i < query.rows; ++i) {
    const Best& best = best_of_query[static_cast<std::size_t>(i)];
    if (best.index < 0 || best.distance > options.max_distance) continue;
    if (options.ratio < 1.0 && best.distance >= options.ratio * best.second_distance) continue;
    if (options.mutual && queries[static_cast<std::size_t>(best.index)] != i) continue;
    matches.push_back({i, best.index, best.distance});
  }
  return matches;
}

}  // namespace highwall
