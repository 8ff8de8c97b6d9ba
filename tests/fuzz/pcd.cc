#include <highwall/mapping/point_cloud_io.h>

#include "fuzz.h"

namespace highwall::fuzz {

const Target kTarget{
    .file_name = "cloud.pcd",
    .seeds =
        [] {
          const std::vector<ColoredPoint> points = {{.p = {1.0f, -2.5f, 0.1f}, .rgb = {1, 2, 255}},
                                                    {.p = {0.0f, 1e9f, -1e-9f}, .rgb = {0, 0, 0}}};
          return std::vector<std::string>{
              Written([&](const auto& path) { WritePcd(path, points); }),
              "VERSION 0.7\nFIELDS intensity x y z\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\n"
              "WIDTH 2\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 2\nDATA ascii\n9 1 2 3\n9 4 5 "
              "6\n",
              "FIELDS x y z\nPOINTS 1\nFIELDS x\nDATA ascii\n1\n",
              std::string("FIELDS x y z\nPOINTS 2\nDATA binary_compressed\n"
                          "\x08\0\0\0\x18\0\0\0\x03\1\2\3\4\xe0\x0b\x03",
                          60)};
        },
    .file = nullptr,
    .read = [](const std::filesystem::path& path) { ReadPcd(path); },
};

}  // namespace highwall::fuzz
