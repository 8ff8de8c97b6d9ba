#pragma once

#include <opencv2/core/mat.hpp>

namespace highwall::simulate {

enum class ExposureMode {
  kIdeal,  // instantaneous, with the rendered brightness; no blur
  kFixed,  // always ExposureOptions::time, without gain
  kAuto,   // the time that the image needs, then gain
};

struct ExposureOptions {
  ExposureMode mode = ExposureMode::kIdeal;
  double time = 0.008;      // [s] > 0 that reproduces the rendered brightness
  double max_time = 0.02;   // [s] >= time; beyond it, gain compensates
  double max_gain = 12.0;   // >= 1
  double target = 100.0;    // [grey levels] in (0, 255): mean of an image
  double vignetting = 0.2;  // [0, 1) loss of light in the corners, except where ideal

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// Exposure of an image.
struct Exposure {
  double time = 0.0;   // [s] shutter time
  double gain = 1.0;   // of the amplifier, which also amplifies noise
  double scale = 1.0;  // of the grey levels, including time and gain
};

// bgr: CV_32FC3, rendered grey levels. The exposure depends on this image alone, as if the control
// had converged.
Exposure ChooseExposure(const ExposureOptions& options, const cv::Mat& bgr);

// Scales CV_32FC3 grey levels by exposure.scale, and less towards the corners.
void Expose(const ExposureOptions& options, const Exposure& exposure, cv::Mat* bgr);

}  // namespace highwall::simulate
