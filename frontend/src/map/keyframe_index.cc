#include <highwall/frontend/map/keyframe_index.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>
#include <random>
#include <utility>

#include <highwall/core/error.h>
#include <highwall/internal/target_clones.h>

namespace highwall {
namespace {

constexpr int kDescriptorBits = 256, kKeyBits = 16, kSignatureBits = 32;
static_assert((kDescriptorBits - kSignatureBits) / kKeyBits - 2 == 12,
              "as many as KeyFrameIndexOptions::tables may be");

// Returns which bits of a descriptor make its signature, and behind them the keys: neighbouring
// bits come from neighbouring tests and are correlated, so the bits are drawn at random, the same
// on every run.
std::array<std::uint8_t, kDescriptorBits> DrawBits() {
  std::array<std::uint8_t, kDescriptorBits> bits{};
  std::iota(bits.begin(), bits.end(), std::uint8_t{0});
  std::mt19937 rng(1);
  for (std::size_t i = bits.size() - 1; i > 0; --i) std::swap(bits[i], bits[rng() % (i + 1)]);
  return bits;
}

// Returns bits [first, first + count) of the drawn ones.
std::uint32_t Sample(const std::uint8_t* descriptor, int first, int count) {
  static const std::array<std::uint8_t, kDescriptorBits> kBits = DrawBits();
  std::uint32_t sample = 0;
  for (int i = 0; i < count; ++i) {
    const unsigned bit = kBits[static_cast<std::size_t>(first + i)];
    sample = (sample << 1) | ((static_cast<unsigned>(descriptor[bit / 8]) >> (bit % 8)) & 1U);
  }
  return sample;
}

std::uint32_t Signature(const std::uint8_t* descriptor) {
  return Sample(descriptor, 0, kSignatureBits);
}

std::uint32_t Key(const std::uint8_t* descriptor, std::size_t table) {
  return Sample(descriptor, kSignatureBits + kKeyBits * static_cast<int>(table), kKeyBits);
}

// Appends to `similar` the keyframes of a bucket whose signature is similar and whose last voter is
// not `voter`, and makes `voter` their last. Clones: queries spend their time on counting bits.
HIGHWALL_TARGET_CLONES("popcnt", "default")
void AppendSimilar(const std::vector<DescriptorTables::Posting>& bucket, std::uint32_t signature,
                   int max_bits, int voter, std::vector<int>* last_voter,
                   std::vector<KeyFrameId>* similar) {
  for (const DescriptorTables::Posting& posting : bucket) {
    if (std::popcount(posting.signature ^ signature) > max_bits) continue;
    int& last = (*last_voter)[posting.keyframe.index()];
    if (last == voter) continue;
    last = voter;
    similar->push_back(posting.keyframe);
  }
}

}  // namespace

DescriptorTables::DescriptorTables(int tables) : tables_(static_cast<std::size_t>(tables)) {}

void DescriptorTables::Add(KeyFrameId keyframe, const cv::Mat& descriptors) {
  for (int i = 0; i < descriptors.rows; ++i) {
    const std::uint8_t* const descriptor = descriptors.ptr(i);
    const Posting posting{keyframe, Signature(descriptor)};
    for (std::size_t t = 0; t < tables_.size(); ++t) {
      tables_[t][Key(descriptor, t)].push_back(posting);
    }
  }
}

void DescriptorTables::Remove(KeyFrameId keyframe, const cv::Mat& descriptors) {
  for (int i = 0; i < descriptors.rows; ++i) {
    for (std::size_t t = 0; t < tables_.size(); ++t) {
      const auto bucket = tables_[t].find(Key(descriptors.ptr(i), t));
      if (bucket == tables_[t].end()) continue;  // two similar descriptors of the keyframe
      std::erase_if(bucket->second, [&](const Posting& p) { return p.keyframe == keyframe; });
      if (bucket->second.empty()) tables_[t].erase(bucket);
    }
  }
}

double DescriptorTables::Vote(const cv::Mat& descriptors, int max_signature_bits, double weight,
                              std::size_t keyframes, std::vector<double>* votes) const {
  const double most = std::log(static_cast<double>(keyframes + 1));
  std::vector<int> last_voter(votes->size(), -1);  // a descriptor votes once per keyframe
  std::vector<KeyFrameId> similar;
  for (int i = 0; i < descriptors.rows; ++i) {
    const std::uint8_t* const descriptor = descriptors.ptr(i);
    const std::uint32_t signature = Signature(descriptor);
    similar.clear();
    for (std::size_t t = 0; t < tables_.size(); ++t) {
      const auto bucket = tables_[t].find(Key(descriptor, t));
      if (bucket == tables_[t].end()) continue;
      AppendSimilar(bucket->second, signature, max_signature_bits, i, &last_voter, &similar);
    }
    if (similar.empty()) continue;
    const double vote = weight * (most - std::log(static_cast<double>(similar.size())));
    for (const KeyFrameId id : similar) (*votes)[id.index()] += vote;
  }
  return weight * most * descriptors.rows;
}

KeyFrameIndex::KeyFrameIndex(const KeyFrameIndexOptions& options)
    : options_((options.Validate(), options)), points_(options.tables), lines_(options.tables) {}

void KeyFrameIndex::Add(KeyFrameId keyframe, const FrameFeatures& features) {
  HIGHWALL_REQUIRE(keyframe > kNoId, "KeyFrameIndex::Add: an id must not be negative");
  points_.Add(keyframe, features.point_descriptors);
  lines_.Add(keyframe, features.line_descriptors);
  ++size_;
  end_ = std::max(end_, keyframe.index() + 1);
}

void KeyFrameIndex::Remove(KeyFrameId keyframe, const FrameFeatures& features) {
  points_.Remove(keyframe, features.point_descriptors);
  lines_.Remove(keyframe, features.line_descriptors);
  --size_;
}

std::vector<PlaceScore> KeyFrameIndex::Query(const FrameFeatures& features) const {
  std::vector<double> votes(end_, 0.0);
  const double most =
      points_.Vote(features.point_descriptors, options_.max_signature_bits, 1.0, size_, &votes) +
      lines_.Vote(features.line_descriptors, options_.max_signature_bits, options_.line_weight,
                  size_, &votes);
  std::vector<PlaceScore> places;
  for (std::size_t i = end_; i-- > 0;) {
    if (votes[i] > 0.0) places.push_back({KeyFrameId(i), votes[i] / most});
  }
  std::stable_sort(places.begin(), places.end(),
                   [](const PlaceScore& a, const PlaceScore& b) { return a.score > b.score; });
  return places;
}

}  // namespace highwall
