#pragma once

#include <filesystem>
#include <string>

#include <highwall/factors/imu_noise_estimation.h>

namespace highwall::apps {

// An SVG with a panel for each sensor, logarithmic on both axes: the Allan deviation with the 95 %
// of its degrees of freedom, the fit, and the kinds of noise that it is made of. Throws IoError.
void WriteAllanPlot(const std::filesystem::path& path, const std::string& title,
                    const ImuNoiseEstimate& estimate);

}  // namespace highwall::apps
