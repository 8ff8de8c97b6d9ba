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
  double noise_ratio = kUsualNoiseRatio;  // > 0; true depth sigma relative to Noise()
  double min_depth = 0.4;                 // [m] > 0; nearer depth is not measured
  double max_depth = 8.0;                 // [m] > min_depth; farther depth is not measured
  // In [-0.1, 0.1]: relative depth error at 3 m, positive if depth is too long. It grows with depth
  // because disparities have a constant offset: z reads as 1 / (1/z + InverseDepthOffset()), and
  // the noise corresponds to this reading. Depth that would be infinite or beyond is not measured.
  double depth_bias = 0.0;
  // In [-0.1, 0.1]: relative depth error at 3 m in the corners of the image minus that in its
  // middle, positive if too long there: a paraboloid of inverse depth with zero mean.
  double depth_pattern = 0.0;
  double colour_sigma = 2.0;  // [grey levels] >= 0; of the Kinect
  StereoOptions stereo{};     // of the D435i
  double read_noise = 0.8;    // [grey levels] >= 0, sigma; of the D435i, times gain
  double shot_noise = 0.02;   // [grey levels] >= 0, variance per grey level; of the D435i, likewise

  // Returns the noise model that an estimator is given: the data sheet's.
  DepthNoise Noise() const;
  double InverseDepthOffset() const;  // [1/m]
  // [1/m] additional to that at x, y in [-1, 1], from one edge of the image to the other.
  double InverseDepthPattern(double x, double y) const;
  DepthPattern Pattern() const;  // best approximation of it

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

struct SensorImages {
  cv::Mat bgr;    // CV_8UC3
  cv::Mat depth;  // CV_32FC1 [m], 0 = no measurement
};

// Simulates a sensor from a rendering. Kinect depth: Gaussian noise of sigma(z) = noise_ratio times
// 0.0012 + 0.0019 (z - 0.4)^2 m (Nguyen, Izadi, Lovell, "Modeling Kinect sensor noise", 3DIMPVT
// 2012, Eq. 4), disparity quantized to 1/8 pixel with a baseline of 75 mm, no depth behind an edge
// (which the projector's light does not reach), and increasingly often none beyond 75 degrees of
// incidence. D435i depth: see StereoDepth. Every pixel of every frame has independent random
// numbers.
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
