#include "bench_loops.h"

#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <optional>
#include <span>
#include <vector>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include <highwall/frontend/system/slam_system.h>

#include "scenes.h"

namespace highwall::bench {
namespace {

// Returns the current memory of the process [MiB].
double MemoryMib() {
  std::ifstream statm("/proc/self/statm");
  double total = 0.0, resident = 0.0;
  statm >> total >> resident;
  return resident * static_cast<double>(::sysconf(_SC_PAGESIZE)) / (1024.0 * 1024.0);
}

// Adds the readings up to shortly after a frame, because they are needed on both sides of its pose.
void AddImu(std::span<const ImuSample> samples, Stamp frame, std::size_t* next, SlamSystem* slam) {
  constexpr Stamp kAhead = 50'000'000;  // [ns], as required by the constructor of SlamSystem
  while (*next < samples.size() && samples[*next].stamp <= frame + kAhead) {
    slam->AddImu(samples[(*next)++]);
  }
}

}  // namespace

nlohmann::json BenchEndurance(double minutes, bool imu) {
  constexpr double kLap = 20.0;  // [s]
  const simulate::Simulation room = MakeRoom(1, 60.0 * minutes);
  const int lap = static_cast<int>(kLap * room.options().fps);
  const std::vector<ImuSample> samples = imu ? room.ImuSamples() : std::vector<ImuSample>();
  std::optional<ImuCalibration> calibration;
  if (imu) calibration = CalibrationOf(room.options().imu);
  SlamSystem slam({.camera = SmallCamera()}, {}, {.imu = calibration});
  std::size_t next = 0;
  nlohmann::json report;
  double first = 0.0, most = 0.0;
  const double before = MemoryMib();  // of the process and the scene
  int lost = 0;
  for (int i = 0; i < room.size(); ++i) {
    const auto frame = room.Render(i);
    AddImu(samples, frame.stamp, &next, &slam);
    const FrameResult result = slam.Track({frame.stamp, frame.bgr, frame.depth});
    lost += HasPose(result.state) ? 0 : 1;
    if ((i + 1) % lap != 0) continue;
    const double memory = MemoryMib();
    const int pass = (i + 1) / lap;
    if (pass == 1) first = memory;
    most = std::max(most, memory);
    fmt::print(stderr, "pass {:>3}: {:.1f} MiB, {} keyframes, {} points, {} lines, {} lost\n", pass,
               memory, slam.map().num_keyframes(), slam.map().num<MapPoint>(),
               slam.map().num<MapLine>(), lost);
    report["runs"].push_back({{"pass", pass},
                              {"memory_mib", memory},
                              {"keyframes", slam.map().num_keyframes()},
                              {"points", slam.map().num<MapPoint>()},
                              {"lines", slam.map().num<MapLine>()}});
  }
  report["minutes"] = minutes;
  report["lost_frames"] = lost;
  report["before_mib"] = before;
  report["first_pass_mib"] = first;
  report["most_mib"] = most;
  report["growth"] = first > 0.0 ? most / first - 1.0 : 0.0;
  return report;
}

}  // namespace highwall::bench
