#pragma once

#include <memory>
#include <vector>

#include <Eigen/Core>

#include "simulate/materials/texture.h"

namespace highwall::simulate {

// Texture stored as images: a pyramid of tiles, each rendered lazily from another texture. A lookup
// therefore has constant cost, however complex the other texture is. It covers the rectangle [min,
// min + size) and repeats beyond. Thread-safe; the content does not depend on the order of lookups.
class BakedTexture final : public Texture {
 public:
  // source: sampled with footprints of one texel. size [m] > 0. texel: of the finest level, about
  // [m] > 0; rounded so that whole tiles fit into size at all levels.
  BakedTexture(std::unique_ptr<const Texture> source, const Eigen::Vector2f& min,
               const Eigen::Vector2f& size, float texel);
  ~BakedTexture() override;

  // Interpolates within a level and between the two levels closest to the footprint.
  Colour Albedo(const Eigen::Vector2f& st, float footprint) const override;

 private:
  struct Tile;
  struct Level;

  const Tile& Fetch(const Level& level, int column, int row) const;
  void Fill(const Level& level, int column, int row, Tile* tile) const;
  Colour Lookup(const Level& level, const Eigen::Vector2f& st) const;

  std::unique_ptr<const Texture> source_;
  Eigen::Vector2f min_;
  std::vector<Level> levels_;
};

}  // namespace highwall::simulate
