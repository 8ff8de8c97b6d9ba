#include <highwall/frontend/input/dataset.h>

#include "fuzz.h"

namespace highwall::fuzz {

const Target kTarget{
    .file_name = "imu.csv",
    .seeds =
        [] {
          return std::vector<std::string>{
              "#timestamp [ns],w_x,w_y,w_z,a_x,a_y,a_z\n1000000000,0.1,-0.2,0.3,0,0,9.81\n"
              "1005000000,0.1,-0.2,0.3,0,0,9.81\n",
              "t wx wy wz ax ay az\n1.000 0 0 0 0 0 9.8\n1.005 0 0 0 0 0 9.8\r\n",
              "\xef\xbb\xbf\"time\"\n1000,1,2,3,4,5,6\n1005,1,2,3,4,5,6\n1e3,1,2,3,4,5,6\n"};
        },
    .file = nullptr,
    .read =
        [](const std::filesystem::path& path) {
          ReadImu(path, {900'000'000, 1'100'000'000});
        },
};

}  // namespace highwall::fuzz
