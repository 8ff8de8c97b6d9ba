#include <highwall/core/pose_graph.h>

#include "fuzz.h"

namespace highwall::fuzz {
namespace {

std::string Graph(PoseGraphSpace space, bool has_poses) {
  const int size = space == PoseGraphSpace::kSe2 ? 3 : 6;
  PoseGraph graph;
  graph.space = space;
  graph.has_poses = has_poses;
  const Pose step = Pose::FromTangent({1, 0, 0}, {0, 0, 0.5});
  graph.nodes = {{0, Pose()}, {7, step}};
  graph.nodes[0].fixed = has_poses;
  graph.edges = {{0, 7, PoseGraphEdgeKind::kLoop, step, PoseInformation::Identity(size, size)}};
  return Written([&](const auto& path) { WriteG2o(path, graph); });
}

}  // namespace

const Target kTarget{
    .file_name = "graph.g2o",
    .seeds =
        [] {
          return std::vector<std::string>{Graph(PoseGraphSpace::kSe3, true),
                                          Graph(PoseGraphSpace::kSe2, true),
                                          Graph(PoseGraphSpace::kSe3, false)};
        },
    .file = nullptr,
    .read =
        [](const std::filesystem::path& path) {
          const PoseGraph graph = ReadG2o(path);
          // A graph that was read can be written and read again.
          const std::filesystem::path again = path.parent_path() / "again.g2o";
          WriteG2o(again, graph);
          ReadG2o(again);
        },
};

}  // namespace highwall::fuzz
