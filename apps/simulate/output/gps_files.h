#pragma once

#include <string>

#include <Eigen/Core>

#include <highwall/core/pose.h>

#include "simulate/camera/simulation.h"

// The part of a dataset that a GPS has, as text.
namespace highwall::simulate {

struct GpsOptions {
  double rate = 1.0;   // [Hz] > 0
  double sigma = 0.5;  // [m] > 0, east and north; up it is twice that
};

// Where the antenna is, in the camera [m]: half a metre above it.
Eigen::Vector3d GpsAntenna();
// T_GW: of the simulated world in the frame of the GPS, whose z axis is up; of the seed.
Pose GpsAlignment(const Simulation& simulation);

// gps.csv: stamp [s], x y z [m] in G, their sigmas; from the first frame to the last.
std::string GpsCsv(const Simulation& simulation, const GpsOptions& options);
// The section `gps` of calibration.yaml: the antenna in the body, that of the IMU where there is
// one.
std::string GpsCalibrationYaml(const SimulationOptions& options);
// groundtruth_gps.txt: T_GW as tx ty tz qx qy qz qw.
std::string GpsAlignmentText(const Simulation& simulation);

}  // namespace highwall::simulate
