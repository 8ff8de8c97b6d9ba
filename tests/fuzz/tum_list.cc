#include <highwall/frontend/input/tum_dataset.h>

#include "fuzz.h"

namespace highwall::fuzz {

const Target kTarget{
    .file_name = "rgb.txt",
    .seeds =
        [] {
          return std::vector<std::string>{
              "# color images\n# file: 'rgbd_dataset_freiburg1_xyz.bag'\n# timestamp filename\n"
              "1305031102.175304 rgb/1305031102.175304.png\n1305031102.211214 rgb/b.png\r\n",
              "1 a\n2.5e0 b extra\n\n3.000000001\tc\n"};
        },
    .file = nullptr,
    .read =
        [](const std::filesystem::path& path) {
          const std::vector<TumImageFile> files = ReadTumImageList(path);
          AssociateNearest(files, files, 20'000'000);
        },
};

}  // namespace highwall::fuzz
