#pragma once

#include <cstdint>

#include <opencv2/core/mat.hpp>

#include <highwall/core/camera.h>
#include <highwall/factors/depth_noise.h>

#include "simulate/camera/renderer.h"
#include "simulate/random.h"

namespace highwall::simulate {

// Stereo pair that estimates depth by matching, like the RealSense D435i's at 848 x 480.
struct StereoOptions {
  double subpixel = 0.08;  // [px] > 0, sigma of a disparity
  double focal = 425.0;    // [px] > 0 of the pair
  double baseline = 0.05;  // [m] > 0

  // sigma_d = subpixel d^2 / (focal baseline), as in the data sheet.
  DepthNoise Noise() const { return DepthNoise::Stereo(subpixel, focal, baseline); }
  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// Depth of such a pair: its noise grows with the square of the distance and is correlated over some
// pixels, since the matching windows overlap. There is no depth where the view of the second
// camera, to the right of the first, is occluded, and little depth without texture and beyond 82
// degrees of incidence.
class StereoDepth {
 public:
  // noise_ratio > 0: true sigma relative to that of options.Noise(). Throws InvalidArgument.
  StereoDepth(const StereoOptions& options, double noise_ratio, const PinholeCamera& camera);

  // rendering.bgr as recorded by the sensor, without noise. random: of this frame. CV_32FC1 [m], 0
  // = no measurement. threads: 0 = one per processor; the result does not depend on it.
  cv::Mat Measure(const Rendering& rendering, const CounterRandom& random, int threads = 0) const;

 private:
  double quadratic_;        // [1/m] sigma of a depth over its square
  double disparity_scale_;  // [px m] of the image: disparity times depth
  NormalTable normals_;
};

}  // namespace highwall::simulate
