#pragma once

#include <algorithm>
#include <cstdint>

#include <Eigen/Core>

// Components of procedural textures: hashes of lattice cells, noise, soft edges.
namespace highwall::simulate {

// Factors of the hash of a lattice point (x, y), applied beforehand: neighbours share the products.
inline constexpr std::uint32_t kHashX = 0x8da6b343u, kHashY = 0xd8163841u;

inline std::uint32_t FinishHash(std::uint32_t x, std::uint32_t y, std::uint32_t seed) {
  std::uint32_t h = x ^ y ^ seed;
  h = (h ^ (h >> 15)) * 0x2c1b3c6du;
  h = (h ^ (h >> 12)) * 0x297a2d39u;
  return h ^ (h >> 15);
}

inline std::uint32_t HashCell(int x, int y, std::uint32_t seed) {
  return FinishHash(static_cast<std::uint32_t>(x) * kHashX, static_cast<std::uint32_t>(y) * kHashY,
                    seed);
}

// Maps a hash to [0, 1).
inline float ToUnit(std::uint32_t h) {
  return static_cast<float>(h >> 8) * 0x1p-24f;
}

// std::floor is a library call on plain x86-64, and was the hot spot of every texture.
inline int Floor(float x) {
  const int i = static_cast<int>(x);
  return static_cast<float>(i) > x ? i - 1 : i;
}

inline float Smooth(float x) {
  return x * x * (3.0f - 2.0f * x);
}

inline float Lerp(float a, float b, float w) {
  return a + (b - a) * w;
}

// Returns the share of a footprint, centred at signed distance `inside` from an edge, that lies
// inside.
inline float Coverage(float inside, float footprint) {
  return std::clamp(0.5f + inside / footprint, 0.0f, 1.0f);
}

// Returns i modulo count, not negative; i itself if count is 0.
inline int Wrap(int i, int count) {
  if (count == 0 || (i >= 0 && i < count)) return i;  // a division is slow
  const int remainder = i % count;
  return remainder < 0 ? remainder + count : remainder;
}

// Returns one octave on the unit lattice, in [-1, 1]. columns: period along x in cells; 0 = none.
inline float LatticeNoise(const Eigen::Vector2f& x, std::uint32_t seed, int columns = 0) {
  const int i = Floor(x.x()), j = Floor(x.y());
  const float a = Smooth(x.x() - static_cast<float>(i)), b = Smooth(x.y() - static_cast<float>(j));
  const std::uint32_t left = static_cast<std::uint32_t>(Wrap(i, columns)) * kHashX;
  const std::uint32_t right =
      columns == 0 ? left + kHashX : static_cast<std::uint32_t>(Wrap(i + 1, columns)) * kHashX;
  const std::uint32_t bottom = static_cast<std::uint32_t>(j) * kHashY, top = bottom + kHashY;
  const float low =
      Lerp(ToUnit(FinishHash(left, bottom, seed)), ToUnit(FinishHash(right, bottom, seed)), a);
  const float high =
      Lerp(ToUnit(FinishHash(left, top, seed)), ToUnit(FinishHash(right, top, seed)), a);
  return 2.0f * Lerp(low, high, b) - 1.0f;
}

}  // namespace highwall::simulate
