#include <highwall/frontend/map/keyframe_index.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>
#include <random>
#include <span>
#include <utility>

#include <highwall/core/error.h>
#include <highwall/internal/target_clones.h>

namespace highwall {
namespace {

constexpr int kDescriptorBits = 256, kKeyBits = 16, kSignatureBits = 32;
constexpr std::size_t kKeys = std::size_t{1} << kKeyBits;
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

// Appends to `similar` the keyframes of postings whose signature is similar and whose last voter is
// not `voter`, and makes `voter` their last. Clones: queries spend their time on counting bits.
HIGHWALL_TARGET_CLONES("popcnt", "default")
void AppendSimilar(std::span<const DescriptorTables::Posting> postings, std::uint32_t signature,
                   int max_bits, int voter, std::vector<int>* last_voter,
                   std::vector<KeyFrameId>* similar) {
  for (const DescriptorTables::Posting& posting : postings) {
    if (std::popcount(posting.signature ^ signature) > max_bits) continue;
    int& last = (*last_voter)[posting.keyframe.index()];
    if (last == voter) continue;
    last = voter;
    similar->push_back(posting.keyframe);
  }
}

}  // namespace

DescriptorTables::DescriptorTables(int tables) : tables_(static_cast<std::size_t>(tables)) {}

DescriptorTables::BlockIndex& DescriptorTables::FirstOf(std::size_t table,
                                                        const std::uint8_t* descriptor) {
  return first_[table * kKeys + Key(descriptor, table)];
}

DescriptorTables::BlockIndex DescriptorTables::FirstOf(std::size_t table,
                                                       const std::uint8_t* descriptor) const {
  return first_[table * kKeys + Key(descriptor, table)];
}

void DescriptorTables::Append(const Posting& posting, BlockIndex* first) {
  if (*first == kNone || blocks_[*first].count == blocks_[*first].postings.size()) {
    const BlockIndex old = *first;
    if (free_ == kNone) {
      *first = static_cast<BlockIndex>(blocks_.size());
      blocks_.emplace_back();
    } else {
      *first = std::exchange(free_, blocks_[free_].next);
    }
    blocks_[*first].next = old;
  }
  Block& block = blocks_[*first];
  block.postings[block.count++] = posting;
}

void DescriptorTables::Erase(KeyFrameId keyframe, BlockIndex* first) {
  for (BlockIndex index = *first; index != kNone;) {
    Block& block = blocks_[index];
    index = block.next;
    for (std::uint32_t i = 0; i < block.count;) {
      if (block.postings[i].keyframe != keyframe) {
        ++i;
        continue;
      }
      Block& head = blocks_[*first];
      block.postings[i] = head.postings[--head.count];
      if (head.count == 0) {
        const BlockIndex emptied = std::exchange(*first, head.next);
        head.next = std::exchange(free_, emptied);
      }
    }
  }
}

void DescriptorTables::Add(KeyFrameId keyframe, const cv::Mat& descriptors) {
  if (first_.empty()) first_.assign(tables_ * kKeys, kNone);
  for (int i = 0; i < descriptors.rows; ++i) {
    const std::uint8_t* const descriptor = descriptors.ptr(i);
    const Posting posting{keyframe, Signature(descriptor)};
    for (std::size_t t = 0; t < tables_; ++t) Append(posting, &FirstOf(t, descriptor));
  }
}

void DescriptorTables::Remove(KeyFrameId keyframe, const cv::Mat& descriptors) {
  if (first_.empty()) return;
  for (int i = 0; i < descriptors.rows; ++i) {
    for (std::size_t t = 0; t < tables_; ++t) Erase(keyframe, &FirstOf(t, descriptors.ptr(i)));
  }
}

double DescriptorTables::Vote(const cv::Mat& descriptors, int max_signature_bits, double weight,
                              std::size_t keyframes, std::vector<double>* votes) const {
  const double most = std::log(static_cast<double>(keyframes + 1));
  if (first_.empty()) return weight * most * descriptors.rows;
  std::vector<int> last_voter(votes->size(), -1);  // a descriptor votes once per keyframe
  std::vector<KeyFrameId> similar;
  for (int i = 0; i < descriptors.rows; ++i) {
    const std::uint8_t* const descriptor = descriptors.ptr(i);
    const std::uint32_t signature = Signature(descriptor);
    similar.clear();
    for (std::size_t t = 0; t < tables_; ++t) {
      for (BlockIndex b = FirstOf(t, descriptor); b != kNone; b = blocks_[b].next) {
        const Block& block = blocks_[b];
        AppendSimilar(std::span(block.postings).first(block.count), signature, max_signature_bits,
                      i, &last_voter, &similar);
      }
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
