#include "simulate/texture.h"

#include <algorithm>
#include <utility>

namespace highwall::simulate {
namespace {

// A hash of lattice point (x, y), x and y multiplied beforehand: neighbours share the products.
constexpr std::uint32_t kHashX = 0x8da6b343u, kHashY = 0xd8163841u;

std::uint32_t FinishHash(std::uint32_t x, std::uint32_t y, std::uint32_t seed) {
  std::uint32_t h = x ^ y ^ seed;
  h = (h ^ (h >> 15)) * 0x2c1b3c6du;
  h = (h ^ (h >> 12)) * 0x297a2d39u;
  return h ^ (h >> 15);
}

std::uint32_t HashCell(int x, int y, std::uint32_t seed) {
  return FinishHash(static_cast<std::uint32_t>(x) * kHashX, static_cast<std::uint32_t>(y) * kHashY,
                    seed);
}

float ToUnit(std::uint32_t h) {
  return static_cast<float>(h >> 8) * 0x1p-24f;
}

// std::floor is a library call on plain x86-64, and the hot spot of the whole renderer.
int Floor(float x) {
  const int i = static_cast<int>(x);
  return static_cast<float>(i) > x ? i - 1 : i;
}

float Smooth(float x) {
  return x * x * (3.0f - 2.0f * x);
}

float Lerp(float a, float b, float w) {
  return a + (b - a) * w;
}

// The share of a footprint centred at signed distance `inside` from an edge that lies within it.
float Coverage(float inside, float footprint) {
  return std::clamp(0.5f + inside / footprint, 0.0f, 1.0f);
}

// One octave on the unit lattice, in [-1, 1].
float LatticeNoise(const Eigen::Vector2f& x, std::uint32_t seed) {
  const int i = Floor(x.x()), j = Floor(x.y());
  const float a = Smooth(x.x() - static_cast<float>(i)), b = Smooth(x.y() - static_cast<float>(j));
  const std::uint32_t left = static_cast<std::uint32_t>(i) * kHashX, right = left + kHashX;
  const std::uint32_t bottom = static_cast<std::uint32_t>(j) * kHashY, top = bottom + kHashY;
  const float low =
      Lerp(ToUnit(FinishHash(left, bottom, seed)), ToUnit(FinishHash(right, bottom, seed)), a);
  const float high =
      Lerp(ToUnit(FinishHash(left, top, seed)), ToUnit(FinishHash(right, top, seed)), a);
  return 2.0f * Lerp(low, high, b) - 1.0f;
}

Colour Shade(const Colour& colour, float brightness) {
  return (colour * brightness).cwiseMax(0.0f).cwiseMin(1.0f);
}

}  // namespace

float ValueNoise::operator()(const Eigen::Vector2f& st, float footprint) const {
  float sum = 0.0f, height = 1.0f, total = 0.0f, length = wavelength;
  for (int octave = 0; octave < octaves; ++octave, height *= 0.6f, length *= 0.5f) {
    total += height;
    // A wave takes two lattice steps; below about four footprints it would flicker.
    const float visible = std::clamp(length / footprint - 1.75f, 0.0f, 1.0f);
    if (visible == 0.0f) continue;
    sum += visible * height *
           LatticeNoise(st / length, seed + static_cast<std::uint32_t>(octave) * 0x9e3779b9u);
  }
  return sum / total;
}

Colour NoiseTexture::Albedo(const Eigen::Vector2f& st, float footprint) const {
  return Shade(colour_, 1.0f + contrast_ * noise_(st, footprint));
}

Colour MasonryTexture::Albedo(const Eigen::Vector2f& st, float footprint) const {
  const MasonryOptions& o = options_;
  const int j = Floor(st.y() / o.cell.y());
  const float s = st.x() + o.shift * o.cell.x() * static_cast<float>(j);
  const int i = Floor(s / o.cell.x());
  const Eigen::Vector2f in_cell(s - static_cast<float>(i) * o.cell.x(),
                                st.y() - static_cast<float>(j) * o.cell.y());

  const std::uint32_t hash = HashCell(i, j, o.noise.seed);
  const float mixture = o.checker ? static_cast<float>((i + j) & 1) : ToUnit(hash);
  Colour colour = o.first + (o.second - o.first) * mixture;
  // Each cell is cut from another place of the material.
  const Eigen::Vector2f cut(static_cast<float>(hash & 0xff), static_cast<float>(hash >> 8 & 0xff));
  colour = Shade(colour, 1.0f + o.contrast * o.noise(st.cwiseProduct(o.stretch) + cut, footprint));

  const float half_joint = 0.5f * o.joint;
  const float to_edge =
      std::min({in_cell.x(), in_cell.y(), o.cell.x() - in_cell.x(), o.cell.y() - in_cell.y()}) -
      half_joint;
  return o.joint_colour + (colour - o.joint_colour) * Coverage(to_edge, footprint);
}

PrintTexture::PrintTexture(const Colour& background, std::vector<PrintPatch> patches,
                           std::uint32_t seed)
    : background_(background),
      patches_(std::move(patches)),
      paper_{.wavelength = 0.03f, .octaves = 2, .seed = seed} {}

Colour PrintTexture::Albedo(const Eigen::Vector2f& st, float footprint) const {
  Colour colour = background_;
  for (const PrintPatch& patch : patches_) {
    const Eigen::Vector2f inside = (st - patch.min).cwiseMin(patch.max - st);
    if (inside.minCoeff() <= -0.5f * footprint) continue;
    const float cover = Coverage(inside.x(), footprint) * Coverage(inside.y(), footprint);
    colour += (patch.colour - colour) * cover;
  }
  constexpr float kPaperContrast = 0.12f;
  return Shade(colour, 1.0f + kPaperContrast * paper_(st, footprint));
}

}  // namespace highwall::simulate
