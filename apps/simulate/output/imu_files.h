#pragma once

#include <span>
#include <string>
#include <vector>

#include <highwall/core/stamp.h>
#include <highwall/factors/imu_buffer.h>

#include "simulate/camera/simulation.h"

// IMU part of a dataset, as text. Columns: Burri et al., "The EuRoC micro aerial vehicle datasets",
// IJRR 35(10), 2016.
namespace highwall::simulate {

// Returns imu.csv: stamp [ns] of the IMU's clock, gyroscope, accelerometer.
std::string ImuCsv(std::span<const ImuSample> samples);

// Returns groundtruth_state.csv: stamp [ns] of the IMU's clock, p_WB, q_WB (w first), v_WB, b_g,
// b_a. stamps: of the camera's clock.
std::string StateCsv(const Simulation& simulation, const std::vector<Stamp>& stamps);

// Returns the section `imu` of calibration.yaml. Its time offset is 0, the initial guess without
// knowledge of the true one.
std::string ImuCalibrationYaml(const ImuSimulationOptions& options);

}  // namespace highwall::simulate
