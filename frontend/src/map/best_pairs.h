#pragma once

#include <cstddef>
#include <limits>
#include <utility>
#include <vector>

namespace highwall {

// The most similar candidate for one feature, and the distance of the second best.
class BestPartner {
 public:
  void Offer(int feature, int hamming) {
    if (hamming < hamming_) {
      second_ = hamming_;
      hamming_ = hamming;
      feature_ = feature;
    } else if (hamming < second_) {
      second_ = hamming;
    }
  }
  // Offering `hamming` at or above this value has no effect.
  int second() const { return second_; }
  int hamming() const { return hamming_; }
  int feature() const { return feature_; }

  // Returns whether the best is similar and unambiguous. max_hamming [bit]; ratio: best against
  // second best.
  bool IsClear(int max_hamming, double ratio) const {
    return feature_ >= 0 && hamming_ <= max_hamming &&
           (second_ == kNone || hamming_ < ratio * second_);
  }

  static constexpr int kNone = std::numeric_limits<int>::max();

 private:
  int feature_ = -1;
  int hamming_ = kNone, second_ = kNone;
};

// Pairs (feature of a, feature of b), each feature once: of several features of a with the same
// partner the most similar is kept, of equal ones the first.
class BestPairs {
 public:
  explicit BestPairs(std::size_t features_b) : owners_(features_b) {}

  void Take(int feature_a, const BestPartner& partner) {
    Owner& owner = owners_[static_cast<std::size_t>(partner.feature())];
    if (partner.hamming() < owner.hamming) owner = {feature_a, partner.hamming()};
  }

  // Sorted by feature of b.
  std::vector<std::pair<int, int>> Pairs() const {
    std::vector<std::pair<int, int>> pairs;
    for (std::size_t j = 0; j < owners_.size(); ++j) {
      if (owners_[j].feature >= 0) pairs.emplace_back(owners_[j].feature, static_cast<int>(j));
    }
    return pairs;
  }

 private:
  struct Owner {
    int feature = -1;
    int hamming = BestPartner::kNone;
  };
  std::vector<Owner> owners_;
};

}  // namespace highwall
