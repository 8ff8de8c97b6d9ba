#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include <highwall/core/pose.h>
#include <highwall/core/solver.h>

namespace ceres {
class CostFunction;
class LossFunction;
}  // namespace ceres

namespace [[gnu::visibility("default")]] highwall {

// Where the poses of a graph live: the plane, with tangent [x y theta], or space, with tangent
// [rho | theta] of SE(3).
enum class PoseGraphSpace { kSe2, kSe3 };

// A pose of a pose graph.
struct PoseGraphNode {
  std::int64_t id = 0;  // >= 0
  Pose pose;            // T_W_id; kSe2: z = 0, rotation about z
  bool fixed = false;   // keeps its pose
};

// 6 x 6 for kSe3, 3 x 3 for kSe2; never on the heap.
using PoseInformation =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, 6, 6>;

// A measured transform between two nodes. An edge between consecutive ids is odometry; any other
// one is a loop, which may be false, unless it is trusted.
struct PoseGraphEdge {
  std::int64_t i = 0;
  std::int64_t j = 0;
  Pose Z;  // measured T_ij, the pose of j in i
  // Of the error Z^-1 T_i^-1 T_j, translation [1/m^2] first; zero in what is not measured.
  PoseInformation information;
  bool trusted = false;  // as odometry is; not kept in files

  bool IsOdometry() const { return j - i == 1 || i - j == 1; }
  bool IsLoop() const { return !trusted && !IsOdometry(); }
};

// A cost of your own on the poses of nodes, in kSe3 only: trusted, weighed by itself and its loss.
// It takes part in solutions and covariances; initializations, chi2 and files know edges alone.
struct PoseGraphFactor {
  std::vector<std::int64_t> nodes;  // by its blocks, each a pose (7, PoseManifold)
  std::shared_ptr<ceres::CostFunction> cost;
  std::shared_ptr<ceres::LossFunction> loss{};  // may be null
};

// Poses and what was measured between them.
struct PoseGraph {
  PoseGraphSpace space = PoseGraphSpace::kSe3;
  std::vector<PoseGraphNode> nodes;
  std::vector<PoseGraphEdge> edges;
  std::vector<PoseGraphFactor> factors{};
  bool has_poses = true;  // false: nobody has given the nodes their poses yet
  // The id of a fixed node at the identity that stands for W: edges from it, which are trusted, are
  // priors on poses. Files hold those as priors, without the node.
  std::optional<std::int64_t> world{};

  // Throws InvalidArgument, naming the node or the edge, for a graph without edges, a negative or
  // repeated id, an edge to a missing node or to itself, a value that is not finite, a pose that
  // leaves the plane of kSe2, an information matrix that has the wrong size, is not symmetric or
  // not positive semidefinite, and a factor in kSe2, without a cost or of a node that is missing.
  void Validate() const;
};

// r^T Omega r, with r = Log(Z^-1 T_i^-1 T_j) in SE(3), translation before rotation, and r = [t
// theta] of Z^-1 T_i^-1 T_j in SE(2); theta in [-pi, pi]. docs/pose_graph.md, Eq. 1 and 2. Of each
// edge, in the order of the edges. Throws as Validate().
std::vector<double> EdgeChi2(const PoseGraph& graph);
// Sum over all edges.
double Chi2(const PoseGraph& graph);

// Where the poses of a graph begin.
enum class PoseGraphInitialization {
  kGiven,     // the poses as they are
  kOdometry,  // composed along odometry; a loop is used only where odometry leads no further
  kTree,      // composed along the spanning tree of fewest edges
  kChordal,   // rotations by linear least squares, projected to SO(d); then positions likewise
};

// Replaces the poses of the nodes that are neither fixed nor the first of a component without a
// fixed node. Those keep theirs; where nobody gave poses they are the identity.
// Source of kChordal: Carlone, Tron, Daniilidis, Dellaert, "Initialization techniques for 3D SLAM",
// ICRA 2015, section III (chordal relaxation, Martinec and Pajdla 2007).
// Throws as Validate(); InvalidArgument for kGiven where has_poses is false, and for kChordal where
// there are factors.
void InitializePoseGraph(PoseGraph* graph, PoseGraphInitialization initialization);

// How false loops are kept from bending the graph. Odometry is trusted. docs/pose_graph.md.
enum class RobustLoops {
  kNone,
  kGnc,  // graduated non-convexity, truncated least squares: Yang, Antonante, Tzoumas, Carlone 2020
  kDcs,  // dynamic covariance scaling: Agarwal et al., ICRA 2013
  kSwitchable,  // switchable constraints: Suenderhauf, Protzel, IROS 2012
};

// What is told while a graph is solved.
struct PoseGraphProgress {
  int iterations = 0;  // so far, over all stages
  double chi2 = 0.0;   // what is minimized at present: robust costs and weights included
};

// Of SolvePoseGraph().
struct PoseGraphOptions {
  RobustLoops robust = RobustLoops::kNone;
  // > 0; a loop whose chi2 exceeds this is false; 0: the 99.9 % quantile, 16.27 in SE(2) and 22.46
  // in SE(3). It is the Phi of DCS and a quarter of the Xi of switchable constraints.
  double max_loop_chi2 = 0.0;
  // Files may claim far too little information. Where loops close far better than it says, less
  // than max_loop_chi2 is taken for plausible. False: the information holds as stated; where it is
  // a bound, or edges were made from the poses themselves, how well they close says nothing.
  bool estimate_variance_factor = true;
  SolveOptions solver = {.max_iterations = 100, .initial_trust_region_radius = 1e12};
  // May be empty; must not throw.
  std::function<void(const PoseGraphProgress&)> on_progress = {};

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// A loop that was found false.
struct RejectedLoop {
  std::size_t edge = 0;  // its place in PoseGraph::edges
  double chi2 = 0.0;     // at the solution
  double weight = 0.0;   // that the robust method gave it, below 0.5
  std::string reason;    // for people
};

// What became of SolvePoseGraph().
struct PoseGraphSummary {
  SolveStatus status = SolveStatus::kFailed;
  std::string message;        // the solver's own words
  double initial_chi2 = 0.0;  // over all edges
  double final_chi2 = 0.0;    // over all edges but the rejected loops
  int iterations = 0;         // steps tried, over all stages
  double seconds = 0.0;       // wall time
  int components = 0;
  std::vector<RejectedLoop> rejected;
  std::vector<std::string> warnings;  // such as a graph in several pieces
};

// Levenberg-Marquardt from the present poses over all nodes but the fixed ones; a component without
// a fixed node keeps the pose of its first. Never throws for a solve that goes badly: see status;
// the poses are then as they were. Throws as Validate() of both arguments; InvalidArgument where
// has_poses is false.
PoseGraphSummary SolvePoseGraph(PoseGraph* graph, const PoseGraphOptions& options = {});

// Joint covariance of nodes at the present poses, given the nodes that SolvePoseGraph() would keep:
// in kSe3 6 rows each, [dp dtheta] of PoseManifold (position in W); in kSe2 3 rows, [x y theta] in
// W. without: edges to leave out, by their place, such as rejected loops. Throws as Validate();
// InvalidArgument for an id that is no node, and if the remaining edges leave one of these nodes
// loose.
Eigen::MatrixXd PoseGraphCovariance(const PoseGraph& graph, std::span<const std::int64_t> ids,
                                    std::span<const std::size_t> without = {});

// Reads a g2o file of one kind:
//   VERTEX_SE3:QUAT id x y z qx qy qz qw
//   EDGE_SE3:QUAT   i j  x y z qx qy qz qw  <21 numbers: upper triangle of the information by rows>
//   VERTEX_SE2      id x y theta
//   EDGE_SE2        i j  x y theta  <6 numbers>
//   EDGE_SE3_PRIOR  id offset  x y z qx qy qz qw  <21 numbers>
//   PARAMS_SE3OFFSET offset  x y z qx qy qz qw
//   EDGE_PRIOR_SE2  id x y theta  <6 numbers>
//   EDGE_PRIOR_SE2_XY id x y  <3 numbers>
//   FIX             id [id ...]
// in any order, separated by blanks or tabs; empty lines and what follows a # are skipped, and so
// are other PARAMS_... lines, which do not touch these edges. Priors are edges from the node
// PoseGraph::world; one without information about the rotation, as of a GPS, has that of its
// vertex. Quaternions are normalised. A file without
// vertices gives the nodes that its edges name, by id, has_poses = false.
// Throws IoError "path:line: what" for any other tag, a wrong number of values, a value that is no
// finite number, a zero quaternion, an information matrix that is not positive
// semidefinite, SE(2) among SE(3), a repeated or negative id, and an edge or FIX that names a
// vertex that is not there; IoError if the file cannot be read or holds no graph.
PoseGraph ReadG2o(const std::filesystem::path& path);

// Writes the same form, whole or not at all (AtomicFile): vertices in order, then FIX, then edges.
// Numbers come back equal, but for the rounding of an angle or a quaternion. Throws as
// PoseGraph::Validate(), but for a graph without edges; IoError if the file cannot be written.
void WriteG2o(const std::filesystem::path& path, const PoseGraph& graph);

}  // namespace highwall
