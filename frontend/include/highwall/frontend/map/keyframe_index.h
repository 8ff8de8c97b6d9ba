#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <vector>

#include <opencv2/core/mat.hpp>

#include <highwall/frontend/features/frame.h>
#include <highwall/frontend/map/map_ids.h>
#include <highwall/frontend/map/options.h>

namespace [[gnu::visibility("default")]] highwall {

// Appearance similarity of a keyframe to a query, in [0, 1].
struct PlaceScore {
  KeyFrameId keyframe = kNoId;
  double score = 0.0;
};

// 256-bit binary descriptors by keyframe: locality-sensitive hashing by sampled bits (Indyk,
// Motwani, STOC 1998). Each table hashes a descriptor by 16 of its bits and stores the keyframe and
// a signature of 32 other bits, so that a query scans its buckets and touches no descriptor. There
// is nothing to train; memory is 8 bytes per descriptor and table, and 256 KiB per table.
class DescriptorTables {
 public:
  // A descriptor of a bucket: its keyframe and its signature.
  struct Posting {
    KeyFrameId keyframe = kNoId;
    std::uint32_t signature = 0;
  };

  explicit DescriptorTables(int tables);

  // descriptors: N x 32 CV_8U or empty, here and below.
  void Add(KeyFrameId keyframe, const cv::Mat& descriptors);
  // Removes what Add() stored; the descriptors must be the same.
  void Remove(KeyFrameId keyframe, const cv::Mat& descriptors);
  // Adds to (*votes)[k] the weight of descriptors similar to those of keyframe k, each weight *
  // log(n / m), where m of `keyframes` = n - 1 keyframes have a similar one (inverse document
  // frequency: Sivic, Zisserman, ICCV 2003). votes: longer than any id. Returns the maximum score
  // of a keyframe.
  double Vote(const cv::Mat& descriptors, int max_signature_bits, double weight,
              std::size_t keyframes, std::vector<double>* votes) const;

  std::size_t MemoryBytes() const {
    return first_.capacity() * sizeof(BlockIndex) + blocks_.size() * sizeof(Block);
  }

 private:
  using BlockIndex = std::uint32_t;  // in blocks_
  static constexpr BlockIndex kNone = 0xffffffff;

  // Part of a bucket, of the size of a cache line. Only the first block of a bucket may have room.
  struct Block {
    std::array<Posting, 7> postings{};
    std::uint32_t count = 0;
    BlockIndex next = kNone;
  };

  BlockIndex& FirstOf(std::size_t table, const std::uint8_t* descriptor);
  BlockIndex FirstOf(std::size_t table, const std::uint8_t* descriptor) const;
  void Append(const Posting& posting, BlockIndex* first);
  void Erase(KeyFrameId keyframe, BlockIndex* first);

  std::size_t tables_;
  std::vector<BlockIndex> first_;  // of each key of each table; empty before the first Add()
  std::deque<Block> blocks_;
  BlockIndex free_ = kNone;  // blocks that hold no posting, linked by `next`
};

// Place recognition without a vocabulary: finds the keyframes that look similar to a query.
// Keyframes are added and removed incrementally; points vote by ORB and lines by LBD.
class KeyFrameIndex {
 public:
  explicit KeyFrameIndex(const KeyFrameIndexOptions& options = {});

  void Add(KeyFrameId keyframe, const FrameFeatures& features);
  // features: as passed to Add().
  void Remove(KeyFrameId keyframe, const FrameFeatures& features);
  // Returns the keyframes with a score above 0, best first; of equal scores the newer first.
  std::vector<PlaceScore> Query(const FrameFeatures& features) const;

  std::size_t size() const { return size_; }
  std::size_t MemoryBytes() const { return points_.MemoryBytes() + lines_.MemoryBytes(); }

 private:
  KeyFrameIndexOptions options_;
  DescriptorTables points_, lines_;
  std::size_t size_ = 0;
  std::size_t end_ = 0;  // above the index of every id that was added
};

}  // namespace highwall
