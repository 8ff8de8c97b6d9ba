#include "simulate/random.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace highwall::simulate {
namespace {

constexpr std::uint64_t kGolden = 0x9e3779b97f4a7c15;

// 24 bits -> [0, 1), exactly representable in a float.
float ToUnit(std::uint64_t bits) {
  return static_cast<float>(bits & 0xffffff) * 0x1p-24f;
}

}  // namespace

std::uint64_t Mix(std::uint64_t x) {
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9;
  x = (x ^ (x >> 27)) * 0x94d049bb133111eb;
  return x ^ (x >> 31);
}

CounterRandom::CounterRandom(std::uint64_t seed) : key_(Mix(seed + kGolden)) {}

CounterRandom CounterRandom::Stream(std::uint64_t stream) const {
  return CounterRandom(key_ ^ Mix(stream * kGolden + 1));
}

std::uint64_t CounterRandom::Bits(std::uint64_t counter) const {
  return Mix(key_ + counter * kGolden);
}

float CounterRandom::Uniform(std::uint64_t counter) const {
  return ToUnit(Bits(counter));
}

Eigen::Vector2f CounterRandom::Normals(std::uint64_t counter) const {
  const std::uint64_t bits = Bits(counter);
  const float radius = std::sqrt(-2.0f * std::log(1.0f - ToUnit(bits)));
  const float angle = 2.0f * std::numbers::pi_v<float> * ToUnit(bits >> 32);
  return {radius * std::cos(angle), radius * std::sin(angle)};
}

NormalTable::NormalTable() : quantiles_(kSize) {
  double x = -4.0;
  double squares = 0.0;
  for (std::size_t i = 0; i < kSize; ++i) {
    // Newton's method on the distribution function, starting from the previous quantile.
    const double p = (static_cast<double>(i) + 0.5) / kSize;
    for (int iteration = 0; iteration < 20; ++iteration) {
      const double density = std::exp(-0.5 * x * x) / std::sqrt(2.0 * std::numbers::pi);
      const double distribution = 0.5 * std::erfc(-x / std::numbers::sqrt2);
      x += std::clamp((p - distribution) / density, -0.5, 0.5);
    }
    quantiles_[i] = static_cast<float>(x);
    squares += x * x;
  }
  // The missing tails reduce the variance slightly.
  const auto scale = static_cast<float>(1.0 / std::sqrt(squares / kSize));
  for (float& quantile : quantiles_) quantile *= scale;
}

}  // namespace highwall::simulate
