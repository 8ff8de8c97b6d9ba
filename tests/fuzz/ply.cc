#include <highwall/mapping/point_cloud_io.h>

#include "fuzz.h"

namespace highwall::fuzz {

const Target kTarget{
    .file_name = "cloud.ply",
    .seeds =
        [] {
          const std::vector<ColoredPoint> points = {
              {.p = {1.0f, -2.5f, 0.1f}, .rgb = {1, 2, 255}, .normal = {0.0f, 0.6f, 0.8f}},
              {.p = {0.0f, 1e9f, -1e-9f}, .rgb = {0, 0, 0}}};
          return std::vector<std::string>{
              Written([&](const auto& path) { WritePly(path, points); }),
              Written([&](const auto& path) { WritePly(path, points, PlyFormat::kAscii); }),
              "ply\r\nformat ascii 1.0\r\ncomment made elsewhere\r\nelement vertex 3\r\n"
              "property double x\r\nproperty double y\r\nproperty double z\r\n"
              "property int16 quality\r\nelement face 1\r\n"
              "property list uint8 int32 vertex_indices\r\nend_header\r\n"
              "0 0 0 1\r\n1 0 0 2\r\n1 1 0 3\r\n3 0 1 2\r\n"};
        },
    .file = nullptr,
    .read = [](const std::filesystem::path& path) { ReadPlyMesh(path); },
};

}  // namespace highwall::fuzz
