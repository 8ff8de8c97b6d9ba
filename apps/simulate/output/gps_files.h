#pragma once

#include <string>

#include <Eigen/Core>

#include <highwall/core/pose.h>

#include "simulate/camera/simulation.h"

// GPS part of a dataset, as text.
namespace highwall::simulate {

struct GpsOptions {
  double rate = 1.0;   // [Hz] > 0
  double sigma = 0.5;  // [m] > 0, east and north; vertically it is doubled
};

// Returns the antenna position in the camera frame [m]: half a metre above the camera.
Eigen::Vector3d GpsAntenna();
// Returns T_GW, from the simulated world to the GPS frame, whose z axis is up; depends on the seed.
Pose GpsAlignment(const Simulation& simulation);

// Returns gps.csv: stamp [s], x y z [m] in G, their sigmas; from the first frame to the last.
std::string GpsCsv(const Simulation& simulation, const GpsOptions& options);
// Returns the section `gps` of calibration.yaml: the antenna in the body frame, that of the IMU if
// there is one.
std::string GpsCalibrationYaml(const SimulationOptions& options);
// Returns groundtruth_gps.txt: T_GW as tx ty tz qx qy qz qw.
std::string GpsAlignmentText(const Simulation& simulation);

}  // namespace highwall::simulate
