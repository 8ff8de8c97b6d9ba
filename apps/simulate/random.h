#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

// Random numbers as pure functions of a seed and counters: the same (seed, counters) give the same
// number, regardless of the number of threads and the order of evaluation.
namespace highwall::simulate {

// The finaliser of SplitMix64: a bijection whose output bits all depend on all input bits.
// Source: Steele, Lea, Flood, "Fast splittable pseudorandom number generators", OOPSLA 2014.
std::uint64_t Mix(std::uint64_t x);

class CounterRandom {
 public:
  explicit CounterRandom(std::uint64_t seed);

  // Returns an independent generator, e.g. one per frame.
  CounterRandom Stream(std::uint64_t stream) const;

  std::uint64_t Bits(std::uint64_t counter) const;
  // In [0, 1).
  float Uniform(std::uint64_t counter) const;
  // Two independent standard normal numbers (Box and Muller 1958).
  Eigen::Vector2f Normals(std::uint64_t counter) const;

 private:
  std::uint64_t key_;
};

// Standard normal numbers from 12 random bits each, by a table of quantiles: up to 3.7 sigma, and
// several times as fast as CounterRandom::Normals.
class NormalTable {
 public:
  NormalTable();

  // Uses the 12 bits above `shift` of [0, 52].
  float operator()(std::uint64_t bits, int shift) const {
    return quantiles_[bits >> shift & (kSize - 1)];
  }

 private:
  static constexpr std::size_t kSize = 4096;
  std::vector<float> quantiles_;
};

// CounterRandom with an internal counter, for code that runs in a fixed order.
class RandomSequence {
 public:
  explicit RandomSequence(std::uint64_t seed) : random_(seed) {}

  std::uint64_t Bits() { return random_.Bits(counter_++); }
  double Uniform(double low, double high) {
    return low + (high - low) * static_cast<double>(random_.Uniform(counter_++));
  }
  // In [0, count).
  int Index(int count) { return static_cast<int>(Uniform(0.0, count)); }

 private:
  CounterRandom random_;
  std::uint64_t counter_ = 0;
};

}  // namespace highwall::simulate
