#include "input/stray_odometry.h"

#include "fuzz.h"

namespace highwall::fuzz {

const Target kTarget{
    .file_name = "odometry.csv",
    .seeds =
        [] {
          return std::vector<std::string>{
              "timestamp, frame, x, y, z, qx, qy, qz, qw\n258528.330141458, 000000, -0.029, 0.331, "
              "0.214, 0.993, 0.0001, -0.115, -0.011\n258528.35, 000001, 1, 2, 3, 0, 0, 0, 1\r\n",
              "timestamp, frame, x, y, z, qx, qy, qz, qw, fx, fy, cx, cy\n1, 2, 3, 4, 5, 0, 0, 0, "
              "1, 1352, 1352, 962, 722\n",
              "1 2 3 4 5 0 0 0 1\n"};
        },
    .file = nullptr,
    .read = [](const std::filesystem::path& path) { ReadStrayOdometry(path); },
};

}  // namespace highwall::fuzz
