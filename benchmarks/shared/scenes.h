#pragma once

#include <string>

#include <highwall/core/trajectory.h>
#include <highwall/frontend/input/sensor.h>
#include <simulate/camera/simulation.h>

namespace highwall::bench {

// The pixels of a Kinect halved: rendering is what a benchmark would else spend its time on.
PinholeCamera SmallCamera();

// A room seen by it at 10 Hz with the noise of a Kinect.
simulate::SimulationOptions SmallRoomOptions(int seed, double seconds);
// The field test's sensor with half the pixels a side, at 10 Hz.
simulate::SimulationOptions SmallFieldTestOptions(int seed, double seconds);

// A room seen by SmallCamera() at 10 Hz, in laps of at most 20 s.
simulate::Simulation MakeRoom(int seed, double seconds);
// scene: mine, road or room.
simulate::Simulation Simulate(const std::string& scene, const simulate::SimulationOptions& options);

// T_WC of every frame.
Trajectory TrueTrajectory(const simulate::Simulation& simulation);
// The poses with stamps in [begin, end].
Trajectory Between(const Trajectory& trajectory, Stamp begin, Stamp end);

ImuCalibration CalibrationOf(const simulate::ImuSimulationOptions& imu);

}  // namespace highwall::bench
