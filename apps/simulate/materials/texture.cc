#include "simulate/materials/texture.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "simulate/materials/lattice_noise.h"

namespace highwall::simulate {
namespace {

Colour Shade(const Colour& colour, float brightness) {
  return (colour * brightness).cwiseMax(0.0f).cwiseMin(1.0f);
}

}  // namespace

float ValueNoise::operator()(const Eigen::Vector2f& st, float footprint) const {
  float sum = 0.0f, height = 1.0f, total = 0.0f, length = wavelength;
  for (int octave = 0; octave < octaves; ++octave, height *= 0.6f, length *= 0.5f) {
    total += height;
    // A wave spans two lattice steps; below about four footprints it would flicker.
    const float visible = std::clamp(length / footprint - 1.75f, 0.0f, 1.0f);
    if (visible == 0.0f) continue;
    const std::uint32_t octave_seed = seed + static_cast<std::uint32_t>(octave) * 0x9e3779b9u;
    if (period == 0.0f) {
      sum += visible * height * LatticeNoise(st / length, octave_seed);
    } else {
      const auto columns = std::max(1.0f, std::round(period / length));
      const Eigen::Vector2f x(st.x() * columns / period, st.y() / length);
      sum += visible * height * LatticeNoise(x, octave_seed, static_cast<int>(columns));
    }
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
  // Each cell shows a different part of the material.
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
