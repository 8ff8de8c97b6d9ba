#include "simulate/strata.h"

#include <algorithm>
#include <cmath>

#include "simulate/lattice_noise.h"
#include "simulate/random.h"

namespace highwall::simulate {
namespace {

constexpr double kLowest = -2.0, kHighest = 14.0;  // [m]
constexpr float kStep = 0.01f;                     // [m] of the table of layers
constexpr float kStretch = 0.45f;                  // bedded rock is streaked along its layers

}  // namespace

Strata::Strata(float period, std::uint32_t seed)
    : period_(period),
      seed_(seed),
      bend_{.wavelength = 4.0f, .octaves = 2, .seed = seed + 11, .period = period},
      ripple_{.wavelength = 0.5f, .octaves = 3, .seed = seed + 12, .period = period} {
  RandomSequence random(Mix(seed));
  for (double bottom = kLowest; bottom < kHighest;) {
    const bool thin = random.Uniform(0.0, 1.0) < 0.45;
    const double thickness = thin ? random.Uniform(0.05, 0.12) : random.Uniform(0.15, 0.42);
    const double block = random.Uniform(1.2, 3.5) * std::max(0.15, thickness);
    layers_.push_back({static_cast<float>(bottom), static_cast<float>(bottom + thickness),
                       static_cast<float>(random.Uniform(0.0, 1.0)),
                       static_cast<float>(random.Uniform(0.0, 1.0)),
                       static_cast<float>(random.Uniform(0.0, thin ? 0.12 : 0.07)),
                       std::max(1, static_cast<int>(static_cast<double>(period) / block)),
                       static_cast<float>(std::max(0.0, random.Uniform(-0.004, 0.022)))});
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
  // A step of the table that two layers share belongs to the lower one.
  auto index = static_cast<std::size_t>(layer_at_[static_cast<std::size_t>(row)]);
  if (h >= layers_[index].top && index + 1 < layers_.size()) ++index;
  if (h < layers_[index].bottom && index > 0) --index;
  const Layer& layer = layers_[index];

  // Joints lean and wander a little.
  const float length = period_ / static_cast<float>(layer.blocks);
  const float phase = ToUnit(HashCell(static_cast<int>(index), 7, seed_));
  const float x = (sh.x() + 0.05f * ripple_({sh.x() + 31.0f, sh.y()}, kSharp)) / length + phase;
  const int i = Floor(x);
  const auto joint = [&](int k) {  // its place within its cell
    return 0.6f * (ToUnit(HashCell(Wrap(k, layer.blocks), static_cast<int>(index), seed_)) - 0.5f);
  };
  const float in_cell = x - static_cast<float>(i) - 0.5f;  // about the joint of this cell
  const float here = joint(i);
  const bool right = in_cell > here;
  const float other = right ? joint(i + 1) + 1.0f : joint(i - 1) - 1.0f;
  const int block = right ? i : i - 1;
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
          .bedding_width = crack};
}

StrataTexture::StrataTexture(const Strata& strata, const StrataColours& colours)
    : strata_(strata),
      colours_(colours),
      grain_{.wavelength = 0.12f,
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
  const float grain = grain_({kStretch * st.x(), st.y()}, footprint);
  const float tone =
      1.0f + 0.16f * place.block_tone + colours_.contrast * grain + 0.22f * stains_(st, footprint);
  constexpr float kJoint = 0.009f;  // [m] width
  const auto crack = [footprint](float distance, float width) {
    const float half = 0.5f * footprint;
    const float overlap =
        std::min(distance + half, 0.5f * width) - std::max(distance - half, -0.5f * width);
    return 1.0f - 0.72f * std::max(0.0f, overlap) / footprint;
  };
  const float cracks =
      std::min(crack(place.to_bedding, place.bedding_width), crack(place.to_joint, kJoint));
  return (colour * (tone * cracks)).cwiseMax(0.0f).cwiseMin(1.0f);
}

}  // namespace highwall::simulate
