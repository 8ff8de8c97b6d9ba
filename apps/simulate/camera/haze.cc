#include "simulate/camera/haze.h"

#include <cmath>

#include "simulate/materials/lattice_noise.h"

namespace highwall::simulate {

void AddHaze(const Haze& haze, double t, Rendering* rendering) {
  if (haze.density <= 0.0) return;
  constexpr float kSkyDistance = 25.0f;  // [m]
  constexpr float kDrift = 0.6f;         // [wavelengths/s]
  const ValueNoise swathes{.wavelength = 1.0f, .octaves = 3, .seed = haze.seed};
  const auto density = static_cast<float>(haze.density);
  const float per_pixel = 3.0f / static_cast<float>(rendering->bgr.cols);  // [wavelengths]
  const cv::Vec3f colour = 255.0f * cv::Vec3f(haze.colour.x(), haze.colour.y(), haze.colour.z());
  for (int v = 0; v < rendering->bgr.rows; ++v) {
    auto* bgr = rendering->bgr.ptr<cv::Vec3f>(v);
    const auto* depth = rendering->depth.ptr<float>(v);
    for (int u = 0; u < rendering->bgr.cols; ++u) {
      const Eigen::Vector2f at(static_cast<float>(u) * per_pixel + kDrift * static_cast<float>(t),
                               static_cast<float>(v) * per_pixel);
      const float z = depth[u] > 0.0f ? depth[u] : kSkyDistance;
      const float share = 1.0f + 0.9f * swathes(at, per_pixel);
      const float clear = std::exp(-density * share * z);
      bgr[u] = colour + clear * (bgr[u] - colour);
    }
  }
}

}  // namespace highwall::simulate
