#include "input/trajectory_log.h"

#include "fuzz.h"

namespace highwall::fuzz {

const Target kTarget{
    .file_name = "trajectory.log",
    .seeds =
        [] {
          return std::vector<std::string>{
              "0 0 1\n1 0 0 1\n0 1 0 2\n0 0 1 3\n0 0 0 1\n"
              "1 1 2\n0 -1 0 1\n1 0 0 2\n0 0 1 3\n0 0 0 1\n",
              "7\t-1 3\r\n1e0 0 0 1\r\n"};
        },
    .file = nullptr,
    .read = [](const std::filesystem::path& path) { ReadTrajectoryLog(path); },
};

}  // namespace highwall::fuzz
