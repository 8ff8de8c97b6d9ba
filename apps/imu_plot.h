#pragma once

#include <filesystem>

#include "slam_run.h"

namespace highwall::apps {

// An SVG of a run with an IMU: above, the weight of its residuals from image to image; below, the
// squared innovation a degree of freedom, which is about 1 where the noise is what the models say.
// inertial: with intervals. Throws IoError.
void WriteImuPlot(const std::filesystem::path& path, const InertialSummary& inertial);

}  // namespace highwall::apps
