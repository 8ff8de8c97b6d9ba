#include "scenes.h"

#include <algorithm>
#include <cstdint>
#include <iterator>

#include <highwall/core/error.h>
#include <simulate/scenes/haul_road.h>
#include <simulate/scenes/mine.h>
#include <simulate/scenes/room.h>

namespace highwall::bench {

PinholeCamera SmallCamera() {
  return {.width = 320, .height = 240, .fx = 262.5, .fy = 262.5, .cx = 159.5, .cy = 119.5};
}

simulate::SimulationOptions SmallRoomOptions(int seed, double seconds) {
  simulate::SimulationOptions options;
  options.seed = static_cast<std::uint64_t>(seed);
  options.duration = seconds;
  options.fps = 10.0;
  options.camera = SmallCamera();
  options.sensor.noise = simulate::SensorNoise::kKinect;
  return options;
}

simulate::SimulationOptions SmallFieldTestOptions(int seed, double seconds) {
  simulate::SimulationOptions options = simulate::FieldTestOptions();
  options.seed = static_cast<std::uint64_t>(seed);
  options.duration = seconds;
  options.fps = 10.0;
  PinholeCamera& camera = options.camera;
  camera.width /= 2;
  camera.height /= 2;
  camera.fx *= 0.5;
  camera.fy *= 0.5;
  camera.cx = 0.5 * camera.cx - 0.25;
  camera.cy = 0.5 * camera.cy - 0.25;
  return options;
}

simulate::Simulation MakeRoom(int seed, double seconds) {
  return simulate::SimulateRoom(SmallRoomOptions(seed, seconds));
}

simulate::Simulation Simulate(const std::string& scene,
                              const simulate::SimulationOptions& options) {
  if (scene == "mine") return simulate::SimulateMine(options);
  if (scene == "road") return simulate::SimulateRoad(options);
  HIGHWALL_REQUIRE(scene == "room", "no scene is called " + scene);
  return simulate::SimulateRoom(options);
}

Trajectory TrueTrajectory(const simulate::Simulation& simulation) {
  Trajectory trajectory;
  for (int i = 0; i < simulation.size(); ++i) {
    const Stamp stamp = simulation.StampOf(i);
    trajectory.push_back({stamp, simulation.T_WC(stamp)});
  }
  return trajectory;
}

Trajectory Between(const Trajectory& trajectory, Stamp begin, Stamp end) {
  Trajectory part;
  std::ranges::copy_if(trajectory, std::back_inserter(part), [&](const StampedPose& pose) {
    return pose.stamp >= begin && pose.stamp <= end;
  });
  return part;
}

ImuCalibration CalibrationOf(const simulate::ImuSimulationOptions& imu) {
  ImuCalibration calibration;
  calibration.T_BC = imu.T_BC;
  calibration.noise = imu.noise;
  calibration.rate = imu.rate;
  return calibration;
}

}  // namespace highwall::bench
