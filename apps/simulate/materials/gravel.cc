#include "simulate/materials/gravel.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "simulate/materials/lattice_noise.h"

namespace highwall::simulate {
namespace {

constexpr int kSides = 3;            // pairs of parallel sides
constexpr float kNarrowest = 0.62f;  // [radii] minimum distance of a side from the middle
constexpr float kReach = 1.25f;      // [radii] extent of a stone with its shadow
constexpr int kMeanGrid = 64;        // samples along a side, for the mean

std::uint32_t LayerSeed(std::uint32_t seed, std::size_t layer) {
  return seed + static_cast<std::uint32_t>(layer + 1) * 0x85ebca6bu;
}

// Byte k of a hash, mapped to [low, high].
float Byte(std::uint32_t hash, int k, float low, float high) {
  return Lerp(low, high, static_cast<float>(hash >> (8 * k) & 0xff) / 255.0f);
}

}  // namespace

// Convex hexagon with three pairs of parallel sides and a flat top.
struct GravelTexture::Stone {
  Eigen::Vector2f centre;                      // [m]
  std::array<Eigen::Vector2f, kSides> normal;  // scaled: a side is where the product is 1
  float radius;                                // [m]
  float top;                                   // of the flat part, relative to the radius
  float tone;                                  // [0, 1] dark to pale
  float rust;                                  // [0, 1]

  // Returns 1 on the outline, 0 in the middle; slope: of the side closest to p, negative on its far
  // half.
  float Distance(const Eigen::Vector2f& p, float* slope, const Eigen::Vector2f& sun) const {
    float greatest = 0.0f;
    for (const Eigen::Vector2f& n : normal) {
      const float d = n.dot(p - centre);
      if (std::abs(d) <= greatest) continue;
      greatest = std::abs(d);
      *slope = (d > 0.0f ? n.dot(sun) : -n.dot(sun)) * radius;
    }
    return greatest;
  }
};

GravelTexture::GravelTexture(const GravelOptions& options)
    : options_(options),
      patches_{.wavelength = 1.9f, .octaves = 4, .seed = options.seed + 1},
      grain_{.wavelength = 0.06f, .octaves = 4, .seed = options.seed + 2} {
  for (std::size_t i = 0; i < options_.layers.size(); ++i) {
    const StoneLayer& layer = options_.layers[i];
    const std::uint32_t seed = LayerSeed(options_.seed, i);
    Mean mean{Colour::Zero(), Colour::Zero()};
    for (int k = 0; k < kMeanGrid * kMeanGrid; ++k) {
      const Eigen::Vector2f st =
          Eigen::Vector2f(static_cast<float>(k % kMeanGrid), static_cast<float>(k / kMeanGrid)) *
          (0.617f * layer.cell);
      const Colour black = Paint(layer, seed, st, 0.1f * layer.cell, Colour::Zero());
      mean.offset += black;
      mean.gain += Paint(layer, seed, st, 0.1f * layer.cell, Colour::Ones()) - black;
    }
    mean.offset /= kMeanGrid * kMeanGrid;
    mean.gain /= kMeanGrid * kMeanGrid;
    means_.push_back(mean);
  }
}

bool GravelTexture::FindStone(const StoneLayer& layer, int i, int j, std::uint32_t seed,
                              const Eigen::Vector2f& st, Stone* stone) {
  const std::uint32_t cell = HashCell(i, j, seed);
  if (ToUnit(cell) >= layer.density) return false;
  const std::uint32_t place = FinishHash(cell, kHashX, seed);
  stone->radius = 0.5f * layer.cell * Byte(place, 0, 0.5f, 0.95f);
  // Anywhere in the cell; including its shadow, a stone does not extend beyond the adjacent cells.
  stone->centre = {(static_cast<float>(i) + Byte(place, 1, 0.1f, 0.9f)) * layer.cell,
                   (static_cast<float>(j) + Byte(place, 2, 0.1f, 0.9f)) * layer.cell};
  if ((st - stone->centre).squaredNorm() > kReach * kReach * stone->radius * stone->radius) {
    return false;
  }
  const std::uint32_t shape = FinishHash(cell, kHashY, seed);
  const std::uint32_t look = FinishHash(place, shape, seed);
  // A direction without trigonometry; the other two are rotated by about 60 degrees each.
  Eigen::Vector2f n(Byte(place, 3, -1.0f, 1.0f), Byte(shape, 3, -1.0f, 1.0f));
  n *= 1.0f / std::sqrt(n.squaredNorm() + 1e-6f);
  for (int k = 0; k < kSides; ++k) {
    stone->normal[static_cast<std::size_t>(k)] =
        n / (stone->radius * Byte(shape, k, kNarrowest, 1.0f));
    n = {0.5f * n.x() - 0.866f * n.y(), 0.866f * n.x() + 0.5f * n.y()};
  }
  stone->top = Byte(look, 0, 0.35f, 0.75f);
  stone->tone = Byte(look, 1, 0.0f, 1.0f);
  stone->rust = std::max(0.0f, Byte(look, 2, -1.6f, 0.9f));
  return true;
}

Colour GravelTexture::Paint(const StoneLayer& layer, std::uint32_t seed, const Eigen::Vector2f& st,
                            float footprint, Colour colour) const {
  const int i0 = Floor(st.x() / layer.cell - 0.5f), j0 = Floor(st.y() / layer.cell - 0.5f);
  Stone stone;
  for (int k = 0; k < 4; ++k) {
    if (!FindStone(layer, i0 + (k & 1), j0 + (k >> 1), seed, st, &stone)) continue;
    float slope = 0.0f;
    const float distance = stone.Distance(st, &slope, options_.sun);
    const float outside = (distance - 1.0f) * stone.radius;
    const float cover = Coverage(-outside, footprint);
    if (cover < 1.0f) {  // a shadow on the far side
      const float reach = 0.3f * stone.radius;
      const float shade =
          std::clamp(1.0f - outside / reach, 0.0f, 1.0f) * std::clamp(-1.5f * slope, 0.0f, 0.75f);
      colour *= 1.0f - shade;
    }
    if (cover == 0.0f) continue;
    Colour face = options_.dark + (options_.pale - options_.dark) * stone.tone;
    face += (options_.rust - face) * stone.rust;
    const float facet = distance < stone.top ? 0.25f : slope;
    face *= 1.0f + layer.relief * facet;
    colour += (face - colour) * cover;
  }
  return colour;
}

Colour GravelTexture::Albedo(const Eigen::Vector2f& st, float footprint) const {
  Colour colour = options_.soil * (1.0f + options_.soil_contrast * patches_(st, footprint));
  for (std::size_t i = 0; i < options_.layers.size(); ++i) {
    const StoneLayer& layer = options_.layers[i];
    // Stones of the size of the footprint fade into their mean.
    const float visible = std::clamp(layer.cell / footprint - 1.0f, 0.0f, 1.0f);
    const Colour mean = means_[i].gain.cwiseProduct(colour) + means_[i].offset;
    if (visible == 0.0f) {
      colour = mean;
      continue;
    }
    const Colour painted = Paint(layer, LayerSeed(options_.seed, i), st, footprint, colour);
    colour = mean + (painted - mean) * visible;
  }
  return (colour * (1.0f + 0.3f * grain_(st, footprint))).cwiseMax(0.0f).cwiseMin(1.0f);
}

}  // namespace highwall::simulate
