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

// Space of the poses of a graph: the plane, with tangent [x y theta], or 3D space, with tangent
// [rho | theta] of SE(3).
enum class PoseGraphSpace { kSe2, kSe3 };

// A pose of a pose graph.
struct PoseGraphNode {
  std::int64_t id = 0;  // >= 0
  Pose pose;            // T_W_id; kSe2: z = 0, rotation about z
  bool fixed = false;   // constant in the optimization
};

// 6 x 6 for kSe3, 3 x 3 for kSe2; without heap allocation.
using PoseInformation =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, 6, 6>;

// Source of a measurement between two nodes.
enum class PoseGraphEdgeKind {
  kOdometry,  // between successive poses of one motion, never an outlier
  kLoop,      // any other measurement, which may be an outlier unless it is trusted
};

// A measured transform between two nodes. Its kind does not depend on the ids of the nodes: these
// may have gaps, and the first pose of one motion may follow the last of another.
struct PoseGraphEdge {
  std::int64_t i = 0;
  std::int64_t j = 0;
  PoseGraphEdgeKind kind = PoseGraphEdgeKind::kLoop;  // not kept in files
  Pose Z;                                             // measured T_ij, the pose of j in i
  // Information of the error Z^-1 T_i^-1 T_j, translation [1/m^2] first; zero for the components
  // that are not measured.
  PoseInformation information;
  bool trusted = false;  // never an outlier, like odometry; not kept in files

  bool IsOdometry() const { return kind == PoseGraphEdgeKind::kOdometry; }
  // Returns whether the edge may be an outlier.
  bool IsLoop() const { return !trusted && !IsOdometry(); }
};

// A user cost on the poses of nodes, in kSe3 only: trusted, weighted by itself and its loss. It is
// used in solutions and covariances; initializations, chi2 and files use the edges only.
struct PoseGraphFactor {
  std::vector<std::int64_t> nodes;  // in the order of its blocks, each a pose (7, PoseManifold)
  std::shared_ptr<ceres::CostFunction> cost;
  std::shared_ptr<ceres::LossFunction> loss{};  // may be null
};

// Poses and the measurements between them.
struct PoseGraph {
  PoseGraphSpace space = PoseGraphSpace::kSe3;
  std::vector<PoseGraphNode> nodes;
  std::vector<PoseGraphEdge> edges;
  std::vector<PoseGraphFactor> factors{};
  bool has_poses = true;  // false: the poses of the nodes have not been initialized
  // Id of a fixed node at the identity that represents W: edges from it, which are trusted, are
  // priors on poses. Files store them as priors, without the node.
  std::optional<std::int64_t> world{};

  // Throws InvalidArgument, naming the node or the edge, for a graph without edges, a negative or
  // repeated id, an edge to a missing node or to itself, a value that is not finite, a pose outside
  // of the plane of kSe2, an information matrix that has the wrong size, is not symmetric or not
  // positive semidefinite, and a factor that is in kSe2, has no cost or refers to a missing node.
  void Validate() const;
};

// Returns r^T Omega r of each edge, in the order of the edges: r = Log(Z^-1 T_i^-1 T_j) in SE(3),
// translation before rotation, and r = [t theta] of Z^-1 T_i^-1 T_j in SE(2), with theta in [-pi,
// pi]. docs/pose_graph.md, Eq. 1 and 2. Throws as Validate().
std::vector<double> EdgeChi2(const PoseGraph& graph);
// Returns the sum over all edges.
double Chi2(const PoseGraph& graph);

// Initial values of the poses of a graph.
enum class PoseGraphInitialization {
  kGiven,     // the poses as they are
  kOdometry,  // composed along odometry; loops only between parts not connected by odometry
  kTree,      // composed along the spanning tree of fewest edges
  kChordal,   // rotations by linear least squares, projected to SO(d); then positions likewise
};

// Replaces the poses of the nodes except the fixed ones and the first node of each component
// without a fixed node. The excepted nodes keep their poses, the identity if has_poses is false.
// Source of kChordal: Carlone, Tron, Daniilidis, Dellaert, "Initialization techniques for 3D SLAM",
// ICRA 2015, section III (chordal relaxation, Martinec and Pajdla 2007).
// Throws as Validate(); InvalidArgument for kGiven where has_poses is false, and for kChordal where
// there are factors.
void InitializePoseGraph(PoseGraph* graph, PoseGraphInitialization initialization);

// Method of robust estimation against outlier loops. Odometry is trusted. docs/pose_graph.md.
enum class RobustLoops {
  kNone,
  kGnc,  // graduated non-convexity, truncated least squares: Yang, Antonante, Tzoumas, Carlone 2020
  kDcs,  // dynamic covariance scaling: Agarwal et al., ICRA 2013
  kSwitchable,  // switchable constraints: Suenderhauf, Protzel, IROS 2012
};

// Progress of SolvePoseGraph().
struct PoseGraphProgress {
  int iterations = 0;  // up to now, over all stages
  double chi2 = 0.0;   // current objective: robust costs and weights included
};

// Options of SolvePoseGraph().
struct PoseGraphOptions {
  RobustLoops robust = RobustLoops::kNone;
  // > 0; a loop whose chi2 exceeds this is false; 0: the 99.9 % quantile, 16.27 in SE(2) and 22.46
  // in SE(3). It is the Phi of DCS and a quarter of the Xi of switchable constraints.
  double max_loop_chi2 = 0.0;
  // Files may contain much too small information. If loops close much better than the information
  // predicts, a loop must stay below a smaller chi2 than max_loop_chi2 to be plausible. False: the
  // information is used as given; the closing errors must not rescale it where it is a lower bound,
  // or where edges were computed from the poses themselves.
  bool estimate_variance_factor = true;
  SolveOptions solver = {.max_iterations = 100, .initial_trust_region_radius = 1e12};
  // May be empty; must not throw.
  std::function<void(const PoseGraphProgress&)> on_progress = {};

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// A loop that was rejected as an outlier.
struct RejectedLoop {
  std::size_t edge = 0;  // index into PoseGraph::edges
  double chi2 = 0.0;     // at the solution
  double weight = 0.0;   // weight of the robust method, below 0.5
  std::string reason;    // human-readable
};

// Summary of SolvePoseGraph().
struct PoseGraphSummary {
  SolveStatus status = SolveStatus::kFailed;
  std::string message;        // message of the solver
  double initial_chi2 = 0.0;  // over all edges
  double final_chi2 = 0.0;    // over all edges except the rejected loops
  int iterations = 0;         // steps tried, over all stages
  double seconds = 0.0;       // wall time
  int components = 0;
  std::vector<RejectedLoop> rejected;
  std::vector<std::string> warnings;  // such as a graph with several components
};

// Runs Levenberg-Marquardt from the current poses over all nodes but the fixed ones; a component
// without a fixed node keeps the pose of its first node. Never throws if the solver fails: see
// status; the poses are then unchanged. Throws as Validate() of both arguments; InvalidArgument if
// has_poses is false.
PoseGraphSummary SolvePoseGraph(PoseGraph* graph, const PoseGraphOptions& options = {});

// Returns the joint covariance of nodes at the current poses, given the nodes that SolvePoseGraph()
// holds constant: in kSe3 6 rows each, [dp dtheta] of PoseManifold (position in W); in kSe2 3 rows,
// [x y theta] in W. without: indices of edges to leave out, such as rejected loops. Empty if one of
// these nodes is not observable from the remaining edges and the factors, or if a factor cannot be
// evaluated. Throws as Validate(); InvalidArgument if has_poses is false, for an id without a node
// and for an index without an edge.
std::optional<Eigen::MatrixXd> PoseGraphCovariance(const PoseGraph& graph,
                                                   std::span<const std::int64_t> ids,
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
// in any order, separated by blanks or tabs; empty lines, the text behind a # and other PARAMS_...
// lines, which do not affect these edges, are skipped. Priors become edges from the node
// PoseGraph::world; a prior without information about the rotation, such as GPS, takes the rotation
// of its vertex. Quaternions are normalised. A file without vertices gives the nodes that its edges
// name, by id, and has_poses = false. The format does not state the kind of an edge: an edge
// between ids that differ by 1 is taken for odometry, any other for a loop. Throws IoError
// "path:line: what" for any other tag, a wrong number of values, a value that is not a finite
// number, a zero quaternion, an information matrix that is not positive semidefinite, SE(2) mixed
// with SE(3), a repeated or negative id, and an edge or FIX that names a missing vertex; IoError if
// the file cannot be read or contains no graph.
PoseGraph ReadG2o(const std::filesystem::path& path);

// Writes the same format atomically (AtomicFile): vertices in order, then FIX, then edges. Numbers
// are read back equal, except for the rounding of an angle or a quaternion, and for the kinds of
// edges, which are not written (ReadG2o). Throws as PoseGraph::Validate(), but not for a graph
// without edges; IoError if the file cannot be written.
void WriteG2o(const std::filesystem::path& path, const PoseGraph& graph);

}  // namespace highwall
