#include "input/matrix_text.h"

#include "fuzz.h"

namespace highwall::fuzz {

const Target kTarget{
    .file_name = "frame-000000.pose.txt",
    .seeds =
        [] {
          return std::vector<std::string>{
              "0.7035 0.3190 -0.6349 -0.9128\n-0.3709 0.9269 0.0547 -0.3438\n0.6060 0.1970 0.7705 "
              "0.7598\n0 0 0 1\n",
              "nan nan nan inf\n0\t1\t0\t0\n0,0,1,0\n0 0 0 1\n"};
        },
    .file = nullptr,
    .read = [](const std::filesystem::path& path) { ReadMatrixText(path, 4, 4); },
};

}  // namespace highwall::fuzz
