#include "simulate/materials/strata.h"

#include <algorithm>
#include <cmath>

#include "simulate/materials/lattice_noise.h"
#include "simulate/random.h"

namespace highwall::simulate {
namespace {

constexpr double kLowest = -2.0, kHighest = 14.0;  // [m]
constexpr float kStep = 0.01f;                     // [m] of the table of layers
constexpr float kStretch = 0.45f;                  // bedded rock is streaked along its layers

// Faces left by broken chips: cells about jittered points, each with a tone in [-1, 1]. They fade
// as the footprint reaches their size.
float Chips(const Eigen::Vector2f& st, float size, float period, std::uint32_t seed,
            float footprint) {
  const float visible = std::clamp(size / footprint - 1.0f, 0.0f, 1.0f);
  if (visible == 0.0f) return 0.0f;
  const float columns = std::max(2.0f, std::round(period / (1.6f * size)));
  const Eigen::Vector2f x(st.x() * columns / period, st.y() / size);
  const int i0 = Floor(x.x() - 0.5f), j0 = Floor(x.y() - 0.5f);
  float nearest = 4.0f, tone = 0.0f;
  for (int k = 0; k < 4; ++k) {
    const int i = i0 + (k & 1), j = j0 + (k >> 1);
    const std::uint32_t hash = HashCell(Wrap(i, static_cast<int>(columns)), j, seed);
    const Eigen::Vector2f point(
        static_cast<float>(i) + static_cast<float>(hash & 0xff) / 255.0f,
        static_cast<float>(j) + static_cast<float>(hash >> 8 & 0xff) / 255.0f);
    const float squared = (x - point).squaredNorm();
    if (squared >= nearest) continue;
    nearest = squared;
    tone = static_cast<float>(hash >> 16 & 0xff) / 127.5f - 1.0f;
  }
  return visible * tone;
}

}  // namespace

Strata::Strata(float period, std::uint32_t seed)
    : period_(period),
      seed_(seed),
      bend_{.wavelength = 4.0f, .octaves = 2, .seed = seed + 11, .period = period},
      ripple_{.wavelength = 0.6f, .octaves = 4, .seed = seed + 12, .period = period} {
  RandomSequence random(Mix(seed));
  for (double bottom = kLowest; bottom < kHighest;) {
    const bool thin = random.Uniform(0.0, 1.0) < 0.45;
    const double thickness = thin ? random.Uniform(0.03, 0.1) : random.Uniform(0.12, 0.38);
    const double block = random.Uniform(1.2, 5.0) * std::max(0.15, thickness);
    layers_.push_back({static_cast<float>(bottom), static_cast<float>(bottom + thickness),
                       static_cast<float>(random.Uniform(0.0, 1.0)),
                       static_cast<float>(random.Uniform(0.0, 1.0)),
                       static_cast<float>(random.Uniform(0.0, thin ? 0.12 : 0.07)),
                       std::max(1, static_cast<int>(static_cast<double>(period) / block)),
                       static_cast<float>(std::max(0.0, random.Uniform(-0.008, 0.018)))});
    bottom += thickness;
    while (static_cast<double>(layer_at_.size()) * kStep + kLowest < bottom) {
      layer_at_.push_back(static_cast<int>(layers_.size()) - 1);
    }
  }
}

Strata::Place Strata::At(const Eigen::Vector2f& sh) const {
  constexpr float kSharp = 0.01f;  // [m]
  const float h = sh.y() + 0.16f * bend_({sh.x(), 0.0f}, kSharp) + 0.035f * ripple_(sh, kSharp);
  const int row = std::clamp(Floor((h - static_cast<float>(kLowest)) / kStep), 0,
                             static_cast<int>(layer_at_.size()) - 1);
  // A table step shared by two layers is assigned to the lower one, then corrected.
  auto index = static_cast<std::size_t>(layer_at_[static_cast<std::size_t>(row)]);
  if (h >= layers_[index].top && index + 1 < layers_.size()) ++index;
  if (h < layers_[index].bottom && index > 0) --index;
  const Layer& layer = layers_[index];

  // Joints are slightly inclined and irregular.
  const float length = period_ / static_cast<float>(layer.blocks);
  const float phase = ToUnit(HashCell(static_cast<int>(index), 7, seed_));
  const float x = (sh.x() + 0.14f * ripple_({sh.x() + 31.0f, sh.y()}, kSharp)) / length + phase;
  const int i = Floor(x);
  const auto joint = [&](int k) {  // its position within its cell
    return 0.6f * (ToUnit(HashCell(Wrap(k, layer.blocks), static_cast<int>(index), seed_)) - 0.5f);
  };
  // Most joints are invisible; an open one ends at the bed that broke it.
  const auto width = [&](int k) {
    const float u = ToUnit(HashCell(Wrap(k, layer.blocks), static_cast<int>(index) + 2000, seed_));
    return 0.016f * std::max(0.0f, u - 0.45f);
  };
  const float in_cell = x - static_cast<float>(i) - 0.5f;  // relative to the cell's middle
  const float here = joint(i);
  const bool right = in_cell > here;
  const float other = right ? joint(i + 1) + 1.0f : joint(i - 1) - 1.0f;
  const int block = right ? i : i - 1;
  const bool nearer_here = std::abs(in_cell - here) < std::abs(other - in_cell);
  const int nearest = nearer_here ? i : (right ? i + 1 : i - 1);
  const std::uint32_t hash =
      HashCell(Wrap(block, layer.blocks), static_cast<int>(index) + 1000, seed_);

  const bool lower = h - layer.bottom < layer.top - h;
  const float crack = lower || index + 1 == layers_.size() ? layer.crack : layers_[index + 1].crack;
  return {.layer_tone = layer.tone,
          .layer_hue = layer.hue,
          .block_tone = 2.0f * ToUnit(hash) - 1.0f,
          .recess = layer.recess + 0.07f * ToUnit(hash * kHashX),
          .to_bedding = std::min(h - layer.bottom, layer.top - h),
          .to_joint = std::min(std::abs(in_cell - here), std::abs(other - in_cell)) * length,
          .bedding_width = crack,
          .joint_width = width(nearest)};
}

StrataTexture::StrataTexture(const Strata& strata, const StrataColours& colours)
    : strata_(strata),
      colours_(colours),
      grain_{.wavelength = 0.1f,
             .octaves = 5,
             .seed = strata.seed() + 21,
             .period = kStretch * strata.period()},
      stains_{
          .wavelength = 1.1f, .octaves = 3, .seed = strata.seed() + 22, .period = strata.period()} {
}

Colour StrataTexture::Albedo(const Eigen::Vector2f& st, float footprint) const {
  const Strata::Place place = strata_.At(st);
  Colour colour = colours_.dark + (colours_.pale - colours_.dark) * place.layer_tone;
  colour += (colours_.ochre - colour) * (0.6f * place.layer_hue * place.layer_hue);
  const float stains = stains_(st, footprint);
  const float grain = grain_({kStretch * st.x(), st.y()}, footprint);
  const float pits = pits_(st, footprint);
  // The grid of the chips is distorted so that it is not visible.
  const Eigen::Vector2f bent = st + 0.04f * Eigen::Vector2f(grain, pits);
  const float chips = Chips(bent, 0.11f, strata_.period(), strata_.seed() + 24, footprint) +
                      0.7f * Chips(bent, 0.035f, strata_.period(), strata_.seed() + 25, footprint);
  const float tone = 1.0f + 0.2f * place.block_tone + 0.5f * colours_.contrast * grain +
                     0.24f * colours_.contrast * chips + 0.22f * stains +
                     0.5f * colours_.contrast * std::min(0.0f, pits + 0.1f);
  const auto crack = [footprint](float distance, float width) {
    const float half = 0.5f * footprint;
    const float overlap =
        std::min(distance + half, 0.5f * width) - std::max(distance - half, -0.5f * width);
    return 1.0f - 0.75f * std::max(0.0f, overlap) / footprint;
  };
  const float cracks = std::min(crack(place.to_bedding, place.bedding_width),
                                crack(place.to_joint, place.joint_width));
  return (colour * (tone * cracks)).cwiseMax(0.0f).cwiseMin(1.0f);
}

}  // namespace highwall::simulate
