#pragma once

#include <filesystem>

#include "run/slam_run.h"

namespace highwall::apps {

// Writes an SVG of a run with an IMU. Top: the weight of the IMU residuals between images. Bottom:
// the squared innovation per degree of freedom, which is about 1 if the noise matches the models.
// inertial: must have intervals. Throws IoError.
void WriteImuPlot(const std::filesystem::path& path, const InertialSummary& inertial);

}  // namespace highwall::apps
