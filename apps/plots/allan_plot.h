#pragma once

#include <filesystem>
#include <string>

#include <highwall/frontend/calibration/imu_noise_estimation.h>

namespace highwall::apps {

// Writes an SVG with one panel per sensor and logarithmic axes: the Allan deviation with its 95 %
// confidence interval from the degrees of freedom, the fit, and the noise terms of the fit. Throws
// IoError.
void WriteAllanPlot(const std::filesystem::path& path, const std::string& title,
                    const ImuNoiseEstimate& estimate);

}  // namespace highwall::apps
