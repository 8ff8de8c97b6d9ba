#include <highwall/core/trajectory.h>

#include "fuzz.h"

namespace highwall::fuzz {

const Target kTarget{
    .file_name = "trajectory.txt",
    .seeds =
        [] {
          const Trajectory trajectory = {
              {1'305'031'102'175'304'000, Pose::FromTangent({1, -2, 0.5}, {0.1, 0.2, -3.0})},
              {1'305'031'102'211'214'000, Pose()}};
          return std::vector<std::string>{
              Written([&](const auto& path) { WriteTumTrajectory(path, trajectory); }), "# none\n",
              "-1.5 0 0 0 0 0 0 1\r\n+2e0 1e-3 +1 1 0.5 0.5 0.5 0.5\n"};
        },
    .file = nullptr,
    .read =
        [](const std::filesystem::path& path) {
          const Trajectory trajectory = ReadTumTrajectory(path);
          for (const StampedPose& pose : trajectory) Interpolate(trajectory, pose.stamp / 2);
          MatchByStamp(trajectory, trajectory, 20'000'000);
        },
};

}  // namespace highwall::fuzz
