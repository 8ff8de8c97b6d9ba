#pragma once

#include <cstdint>

#include <opencv2/core/mat.hpp>

#include <highwall/core/camera.h>
#include <highwall/factors/depth_noise.h>
#include <highwall/factors/depth_pattern.h>

#include "simulate/camera/renderer.h"
#include "simulate/camera/stereo_depth.h"
#include "simulate/noise_ratio.h"
#include "simulate/random.h"

namespace highwall::simulate {

enum class SensorNoise {
  kOff,     // exact depth within the range, colours rounded
  kKinect,  // structured light, 640 x 480
  kD435i,   // stereo, and a camera whose noise depends on light and gain
};

struct SensorOptions {
  SensorNoise noise = SensorNoise::kKinect;
  double noise_ratio = kUsualNoiseRatio;  // > 0; the depth's true sigma over that of Noise()
  double min_depth = 0.4;                 // [m] > 0; nearer is not measured
  double max_depth = 8.0;                 // [m] > min_depth; nor farther
  // In [-0.1, 0.1]: the share by which depth reads too long at 3 m; it grows with depth, for
  // disparities are off by a constant: z reads as 1 / (1/z + InverseDepthOffset()), to which the
  // noise belongs. What would be at infinity or beyond is not measured.
  double depth_bias = 0.0;
  // In [-0.1, 0.1]: by how much more of itself depth reads too long in the corners of the image
  // than in its middle, at 3 m: a paraboloid of inverse depth, 0 in the mean.
  double depth_pattern = 0.0;
  double colour_sigma = 2.0;  // [grey levels] >= 0; of the Kinect
  StereoOptions stereo{};     // of the D435i
  double read_noise = 0.8;    // [grey levels] >= 0, sigma; of the D435i, times gain
  double shot_noise = 0.02;   // [grey levels] >= 0, variance per grey level; of the D435i, likewise

  // What an estimator is told of the depth's sigma: the data sheet's.
  DepthNoise Noise() const;
  double InverseDepthOffset() const;  // [1/m]
  // [1/m] More than that at x, y in [-1, 1], from one edge of the image to the other.
  double InverseDepthPattern(double x, double y) const;
  DepthPattern Pattern() const;  // the nearest to that

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

struct SensorImages {
  cv::Mat bgr;    // CV_8UC3
  cv::Mat depth;  // CV_32FC1 [m], 0 = no measurement
};

// From what is there to what a sensor reports. Kinect depth: Gaussian noise of
// sigma(z) = noise_ratio times 0.0012 + 0.0019 (z - 0.4)^2 m (Nguyen, Izadi, Lovell, "Modeling
// Kinect sensor noise", 3DIMPVT 2012, Eq. 4), disparity in steps of 1/8 pixel over a baseline of 75
// mm, no depth behind an edge (there the projector's light does not arrive) nor, more and more
// often, beyond 75 degrees of incidence. D435i depth: see StereoDepth. Every pixel of every frame
// has random numbers of its own.
class Sensor {
 public:
  // Throws InvalidArgument.
  Sensor(const SensorOptions& options, const PinholeCamera& camera, std::uint64_t seed);

  // gain: of the amplifier.
  SensorImages Observe(const Rendering& rendering, int frame, int threads = 0,
                       double gain = 1.0) const;

 private:
  // depth: CV_32FC1 [m].
  cv::Mat Biased(const cv::Mat& depth) const;
  cv::Mat KinectDepth(const Rendering& rendering, const CounterRandom& random, int threads) const;
  cv::Mat KinectColour(const cv::Mat& bgr, const CounterRandom& random, int threads) const;
  cv::Mat CameraColour(const cv::Mat& bgr, const CounterRandom& random, int threads,
                       double gain) const;

  SensorOptions options_;
  double disparity_scale_;  // [px m] disparity = scale / depth
  CounterRandom random_;
  StereoDepth stereo_;
  NormalTable normals_;
};

}  // namespace highwall::simulate
