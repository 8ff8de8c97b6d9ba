#pragma once

#include <filesystem>

#include <highwall/core/pose_graph.h>

namespace highwall {

// Reads a g2o file of one kind:
//   VERTEX_SE3:QUAT id x y z qx qy qz qw
//   EDGE_SE3:QUAT   i j  x y z qx qy qz qw  <21 numbers: upper triangle of the information by rows>
//   VERTEX_SE2      id x y theta
//   EDGE_SE2        i j  x y theta  <6 numbers>
//   FIX             id [id ...]
// in any order, separated by blanks or tabs; empty lines and what follows a # are skipped, and so
// are PARAMS_... lines, which do not touch these edges. Quaternions are normalised. A file without
// vertices gives the nodes that its edges name, by id, has_poses = false.
// Throws IoError "path:line: what" for any other tag, a wrong number of values, a value that is no
// finite number, a zero quaternion, an information matrix that is not positive definite, SE(2)
// among SE(3), a repeated or negative id, and an edge or FIX that names a vertex that is not there;
// IoError if the file cannot be read or holds no graph.
PoseGraph ReadG2o(const std::filesystem::path& path);

// Writes the same form, whole or not at all (AtomicFile): vertices in order, then FIX, then edges.
// Numbers come back equal, but for the rounding of an angle or a quaternion. Throws as
// PoseGraph::Validate(), but for a graph without edges; IoError if the file cannot be written.
void WriteG2o(const std::filesystem::path& path, const PoseGraph& graph);

}  // namespace highwall
