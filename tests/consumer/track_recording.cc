// Tracks a recording and writes its trajectory.
#include <highwall/frontend/input/open_dataset.h>
#include <highwall/frontend/system/slam_system.h>

int main() {
  using namespace highwall;
  const RgbdSensor sensor = *SensorPreset("tum1");
  const auto images = OpenDataset("rgbd_dataset_freiburg1_xyz", sensor);
  SlamSystem slam(sensor);
  for (std::size_t i = 0; i < images->size(); ++i) {
    if (const auto image = images->Load(i)) slam.Track(*image);
  }
  slam.Finish();
  WriteTumTrajectory("trajectory.txt", slam.trajectory());
}
