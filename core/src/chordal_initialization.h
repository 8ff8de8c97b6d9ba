#pragma once

#include <highwall/core/pose_graph.h>
#include "pose_graph_topology.h"

namespace highwall::internal {

// InitializePoseGraph() by chordal relaxation; held nodes keep their poses.
void InitializeChordal(const PoseGraphTopology& topology, PoseGraph* graph);

}  // namespace highwall::internal
