#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "simulate/materials/texture.h"

namespace highwall::simulate {

// Face of bedded rock: layers of uneven thickness, each broken into blocks by joints. s [m] runs
// along the face and repeats every `period`; h [m] is the height.
class Strata {
 public:
  // Properties of a point of the face.
  struct Place {
    float layer_tone, layer_hue;  // [0, 1] of the layer
    float block_tone;             // [-1, 1] of the block
    float recess;                 // [m] >= 0, depth of the block behind the face
    float to_bedding, to_joint;   // [m] to the nearest boundary of the layer, of the block
    float bedding_width;          // [m] of the crack between the layers; 0 = closed
    float joint_width;            // [m] likewise
  };

  // period [m] > 0.
  Strata(float period, std::uint32_t seed);

  float period() const { return period_; }
  std::uint32_t seed() const { return seed_; }
  Place At(const Eigen::Vector2f& sh) const;

 private:
  struct Layer {
    float bottom, top;  // [m]
    float tone, hue;    // [0, 1]
    float recess;       // [m]
    int blocks;         // around the period
    float crack;        // [m] width of its lower boundary
  };

  float period_;
  std::uint32_t seed_;
  std::vector<Layer> layers_;
  std::vector<int> layer_at_;  // index, by steps of height
  ValueNoise bend_, ripple_;
};

struct StrataColours {
  Colour dark = Rgb(0.36, 0.30, 0.26);
  Colour pale = Rgb(0.68, 0.60, 0.50);
  Colour ochre = Rgb(0.62, 0.44, 0.28);
  float contrast = 0.75f;  // of the grain
};

// Colours of such a face; texture coordinates are (s, h).
class StrataTexture final : public Texture {
 public:
  StrataTexture(const Strata& strata, const StrataColours& colours);
  Colour Albedo(const Eigen::Vector2f& st, float footprint) const override;

 private:
  Strata strata_;
  StrataColours colours_;
  ValueNoise grain_, pits_, stains_;
};

}  // namespace highwall::simulate
