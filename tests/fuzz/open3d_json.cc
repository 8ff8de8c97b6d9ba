#include "input/open3d_intrinsic.h"

#include "fuzz.h"

namespace highwall::fuzz {

const Target kTarget{
    .file_name = "camera_intrinsic.json",
    .seeds =
        [] {
          return std::vector<std::string>{
              "{\n\t\"width\" : 640,\n\t\"height\" : 480,\n\t\"intrinsic_matrix\" :\n\t[ 380.7, 0, "
              "0, "
              "0, 380.3, 0, 314.1, 241.4, 1 ],\n\t\"depth_scale\" : 1000\n}\n",
              "{\"intrinsic_matrix\":[1,0,0,0,1,0,0,0,1],\"width\":1,\"height\":1}"};
        },
    .file = nullptr,
    .read = [](const std::filesystem::path& path) { ReadOpen3dIntrinsic(path); },
};

}  // namespace highwall::fuzz
