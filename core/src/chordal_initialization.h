#pragma once

#include <highwall/core/pose_graph.h>
#include "pose_graph_topology.h"

namespace highwall::internal {

// InitializePoseGraph() by chordal relaxation; the poses of held nodes are taken as they are.
void InitializeChordal(const PoseGraphTopology& topology, PoseGraph* graph);

}  // namespace highwall::internal
