#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

// Procedural surface textures. A texture is a pure function of the surface coordinates st = (s, t)
// [m], s to the right and t up as seen from the front. No pixels are stored, so that it is equally
// sharp at any distance.
namespace highwall::simulate {

// Reflectance in [0, 1]: blue, green, red (the order of the images).
using Colour = Eigen::Vector3f;

inline Colour Rgb(double r, double g, double b) {
  return Eigen::Vector3d(b, g, r).cast<float>();
}

class Texture {
 public:
  virtual ~Texture() = default;
  // Returns the reflectance averaged approximately over a square of side `footprint` [m] at st:
  // detail finer than a pixel fades instead of flickering.
  virtual Colour Albedo(const Eigen::Vector2f& st, float footprint) const = 0;
};

// Fractal value noise with about zero mean, in [-1, 1]: `octaves` from `wavelength` [m] downwards,
// each with half the wavelength and 0.6 times the amplitude of the previous one.
struct ValueNoise {
  float wavelength = 0.1f;
  int octaves = 4;
  std::uint32_t seed = 0;
  float period = 0.0f;  // [m] along s; 0 = none

  float operator()(const Eigen::Vector2f& st, float footprint) const;
};

// Plaster, carpet, board: one colour with brightness noise.
class NoiseTexture final : public Texture {
 public:
  // contrast: relative, 0 = uniform.
  NoiseTexture(const Colour& colour, float contrast, const ValueNoise& noise)
      : colour_(colour), contrast_(contrast), noise_(noise) {}
  Colour Albedo(const Eigen::Vector2f& st, float footprint) const override;

 private:
  Colour colour_;
  float contrast_;
  ValueNoise noise_;
};

struct MasonryOptions {
  Eigen::Vector2f cell = {0.25f, 0.08f};  // [m] one brick, tile or plank, joint included
  float joint = 0.01f;                    // [m] width of the joint
  float shift = 0.5f;                     // [cells] offset of each row to the row below; 0 = a grid
  bool checker = false;                   // colours alternate; otherwise a random mixture per cell
  Colour first = Rgb(0.6, 0.3, 0.2);
  Colour second = Rgb(0.4, 0.2, 0.15);
  Colour joint_colour = Rgb(0.7, 0.7, 0.68);
  float contrast = 0.3f;                   // of the noise inside a cell
  Eigen::Vector2f stretch = {1.0f, 1.0f};  // of the noise: (1, 8) is a grain along s
  ValueNoise noise{};
};

// Bricks, tiles, checkerboards, planks: cells in rows with joints between them.
class MasonryTexture final : public Texture {
 public:
  explicit MasonryTexture(const MasonryOptions& options) : options_(options) {}
  Colour Albedo(const Eigen::Vector2f& st, float footprint) const override;

 private:
  MasonryOptions options_;
};

// Axis-parallel patch of one colour, [m].
struct PrintPatch {
  Eigen::Vector2f min, max;
  Colour colour;
};

// Patches painted over a background in their order: posters, book spines, drawers, labels.
class PrintTexture final : public Texture {
 public:
  PrintTexture(const Colour& background, std::vector<PrintPatch> patches, std::uint32_t seed);
  Colour Albedo(const Eigen::Vector2f& st, float footprint) const override;

 private:
  Colour background_;
  std::vector<PrintPatch> patches_;
  ValueNoise paper_;
};

}  // namespace highwall::simulate
