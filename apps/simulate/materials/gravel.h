#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "simulate/materials/texture.h"

namespace highwall::simulate {

// Stones of one size, one or none in each cell of a square lattice.
struct StoneLayer {
  float cell = 0.05f;    // [m] > 0; the diameter of a stone is 0.5 to 0.95 of it
  float density = 0.5f;  // [0, 1] share of cells with a stone
  float relief = 0.45f;  // [0, 1] brightness contrast of facets
};

struct GravelOptions {
  Colour soil = Rgb(0.42, 0.36, 0.29);
  float soil_contrast = 0.45f;
  Colour dark = Rgb(0.30, 0.28, 0.27);  // stones mix these two,
  Colour pale = Rgb(0.66, 0.61, 0.54);
  Colour rust = Rgb(0.50, 0.36, 0.25);  // and some are tinged with this one
  std::vector<StoneLayer> layers = {{0.017f, 0.75f, 0.35f},
                                    {0.041f, 0.55f, 0.45f},
                                    {0.11f, 0.22f, 0.5f}};  // larger ones lie on top
  Eigen::Vector2f sun = {-0.6f, -0.8f};  // unit; direction towards the light in (s, t)
  std::uint32_t seed = 0;
};

// Crushed rock on soil: convex stones of few facets, lit from one side, with their shadows.
class GravelTexture final : public Texture {
 public:
  explicit GravelTexture(const GravelOptions& options);
  Colour Albedo(const Eigen::Vector2f& st, float footprint) const override;

 private:
  struct Stone;
  // Mean effect of a layer on a colour from a distance: gain * colour + offset.
  struct Mean {
    Colour gain, offset;
  };

  // Finds the stone of cell (i, j) if it covers st.
  static bool FindStone(const StoneLayer& layer, int i, int j, std::uint32_t seed,
                        const Eigen::Vector2f& st, Stone* stone);
  // Returns `colour` with the stones of a layer on it, and their shadows.
  Colour Paint(const StoneLayer& layer, std::uint32_t seed, const Eigen::Vector2f& st,
               float footprint, Colour colour) const;

  GravelOptions options_;
  ValueNoise patches_, grain_;
  std::vector<Mean> means_;  // one per layer
};

}  // namespace highwall::simulate
