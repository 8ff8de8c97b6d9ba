#pragma once

#include <cstdint>

#include <opencv2/core/mat.hpp>

#include <highwall/core/camera.h>

#include "simulate/random.h"
#include "simulate/renderer.h"

namespace highwall::simulate {

enum class SensorNoise {
  kOff,     // exact depth within the range, colours rounded
  kKinect,  // structured light, 640 x 480
};

struct SensorOptions {
  SensorNoise noise = SensorNoise::kKinect;
  double min_depth = 0.4;     // [m] > 0; nearer is not measured
  double max_depth = 8.0;     // [m] > min_depth; nor farther
  double colour_sigma = 2.0;  // [grey levels] >= 0; unless the noise is off

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

struct SensorImages {
  cv::Mat bgr;    // CV_8UC3
  cv::Mat depth;  // CV_32FC1 [m], 0 = no measurement
};

// From what is there to what a sensor reports. Kinect depth: Gaussian noise of
// sigma(z) = 0.0012 + 0.0019 (z - 0.4)^2 m (Nguyen, Izadi, Lovell, "Modeling Kinect sensor noise",
// 3DIMPVT 2012, Eq. 4), disparity in steps of 1/8 pixel over a baseline of 75 mm, no depth behind
// an edge (there the projector's light does not arrive) nor, more and more often, beyond 75 degrees
// of incidence. Every pixel of every frame has random numbers of its own.
class Sensor {
 public:
  // Throws InvalidArgument.
  Sensor(const SensorOptions& options, const PinholeCamera& camera, std::uint64_t seed);

  SensorImages Observe(const Rendering& rendering, int frame, int threads = 0) const;

 private:
  SensorOptions options_;
  double disparity_scale_;  // [px m] disparity = scale / depth
  CounterRandom random_;
};

}  // namespace highwall::simulate
