#include <highwall/mapping/octomap_builder.h>

#include "fuzz.h"

namespace highwall::fuzz {

const Target kTarget{
    .file_name = "map.bt",
    .seeds =
        [] {
          OctomapBuilder map({.resolution = 0.2});
          const std::vector<Eigen::Vector3f> points = {{0.5f, 0.0f, 1.0f}, {-0.5f, 0.3f, 1.2f}};
          map.Insert(points, Pose());
          return std::vector<std::string>{
              Written([&](const auto& path) { map.WriteBinary(path); }),
              Written([&](const auto& path) { map.Write(path); }),
              Written([&](const auto& path) { OctomapBuilder().WriteBinary(path); })};
        },
    .file = nullptr,
    .read =
        [](const std::filesystem::path& path) {
          const OctomapBuilder map = OctomapBuilder::Read(path);
          map.LeafCount();
          map.Bounds();
        },
};

}  // namespace highwall::fuzz
