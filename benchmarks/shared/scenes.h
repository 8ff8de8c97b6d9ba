#pragma once

#include <string>

#include <highwall/core/trajectory.h>
#include <highwall/frontend/input/sensor.h>
#include <simulate/camera/simulation.h>

namespace highwall::bench {

// Returns a camera with half the pixels of a Kinect: rendering would otherwise dominate the time of
// a benchmark.
PinholeCamera SmallCamera();

// Returns options of a room observed by it at 10 Hz with the noise of a Kinect.
simulate::SimulationOptions SmallRoomOptions(int seed, double seconds);
// Returns options of the field test's sensor with half the pixels per side, at 10 Hz.
simulate::SimulationOptions SmallFieldTestOptions(int seed, double seconds);

// Simulates a room observed by SmallCamera() at 10 Hz, in laps of at most 20 s.
simulate::Simulation MakeRoom(int seed, double seconds);
// scene: mine, road or room.
simulate::Simulation Simulate(const std::string& scene, const simulate::SimulationOptions& options);

// Returns T_WC of every frame.
Trajectory TrueTrajectory(const simulate::Simulation& simulation);
// Returns the poses with stamps in [begin, end].
Trajectory Between(const Trajectory& trajectory, Stamp begin, Stamp end);

ImuCalibration CalibrationOf(const simulate::ImuSimulationOptions& imu);

}  // namespace highwall::bench
