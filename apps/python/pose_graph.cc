#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <utility>
#include <vector>

#include <highwall/core/pose_graph.h>

#include "bindings.h"
#include "exclusive.h"

namespace highwall::python {
namespace {

void BindGraph(py::module_& module) {
  py::enum_<PoseGraphSpace>(module, "PoseGraphSpace")
      .value("SE2", PoseGraphSpace::kSe2)
      .value("SE3", PoseGraphSpace::kSe3);
  py::enum_<PoseGraphEdgeKind>(module, "PoseGraphEdgeKind", "The source of a measurement.")
      .value("ODOMETRY", PoseGraphEdgeKind::kOdometry)
      .value("LOOP", PoseGraphEdgeKind::kLoop);
  py::class_<PoseGraphNode>(module, "PoseGraphNode", "A pose T_W_id of a pose graph.")
      .def(py::init([](std::int64_t id, const Pose& pose, bool fixed) {
             return PoseGraphNode{id, pose, fixed};
           }),
           py::arg("id"), py::arg("pose"), py::arg("fixed") = false)
      .def_readwrite("id", &PoseGraphNode::id)
      .def_readwrite("pose", &PoseGraphNode::pose)
      .def_readwrite("fixed", &PoseGraphNode::fixed);
  py::class_<PoseGraphEdge>(module, "PoseGraphEdge",
                            "A measured T_ij with its information, translation first. A loop may "
                            "be false, odometry is not.")
      .def(py::init([](std::int64_t i, std::int64_t j, PoseGraphEdgeKind kind, const Pose& Z,
                       const PoseInformation& information, bool trusted) {
             return PoseGraphEdge{i, j, kind, Z, information, trusted};
           }),
           py::arg("i"), py::arg("j"), py::arg("kind"), py::arg("Z"), py::arg("information"),
           py::arg("trusted") = false)
      .def_readwrite("i", &PoseGraphEdge::i)
      .def_readwrite("j", &PoseGraphEdge::j)
      .def_readwrite("kind", &PoseGraphEdge::kind)
      .def_readwrite("Z", &PoseGraphEdge::Z)
      .def_readwrite("information", &PoseGraphEdge::information)
      .def_readwrite("trusted", &PoseGraphEdge::trusted);
  py::class_<PoseGraph>(module, "PoseGraph",
                        "Nodes and edges. The lists are copies: assign one to change it.")
      .def(py::init([](const std::vector<PoseGraphNode>& nodes,
                       const std::vector<PoseGraphEdge>& edges, PoseGraphSpace space) {
             return PoseGraph{.space = space, .nodes = nodes, .edges = edges};
           }),
           py::arg("nodes"), py::arg("edges"), py::arg("space") = PoseGraphSpace::kSe3)
      .def_readonly("space", &PoseGraph::space)
      .def_readwrite("nodes", &PoseGraph::nodes)
      .def_readwrite("edges", &PoseGraph::edges)
      .def_readonly("has_poses", &PoseGraph::has_poses);
}

void BindGraphOptions(py::module_& module) {
  py::enum_<PoseGraphInitialization>(module, "PoseGraphInitialization")
      .value("GIVEN", PoseGraphInitialization::kGiven)
      .value("ODOMETRY", PoseGraphInitialization::kOdometry)
      .value("TREE", PoseGraphInitialization::kTree)
      .value("CHORDAL", PoseGraphInitialization::kChordal);
  py::enum_<RobustLoops>(module, "RobustLoops", "How false loops are kept from bending the graph.")
      .value("NONE", RobustLoops::kNone)
      .value("GNC", RobustLoops::kGnc)
      .value("DCS", RobustLoops::kDcs)
      .value("SWITCHABLE", RobustLoops::kSwitchable);
  py::class_<PoseGraphOptions> options(module, "PoseGraphOptions", "Of solve_pose_graph().");
  KeywordConstructor<PoseGraphOptions>(options);
  options.def_readwrite("robust", &PoseGraphOptions::robust)
      .def_readwrite("max_loop_chi2", &PoseGraphOptions::max_loop_chi2)
      .def_readwrite("estimate_variance_factor", &PoseGraphOptions::estimate_variance_factor)
      .def_readwrite("solver", &PoseGraphOptions::solver);
  py::class_<RejectedLoop>(module, "RejectedLoop", "A loop that was found false.")
      .def_readonly("edge", &RejectedLoop::edge, "Its place among the edges.")
      .def_readonly("chi2", &RejectedLoop::chi2)
      .def_readonly("weight", &RejectedLoop::weight)
      .def_readonly("reason", &RejectedLoop::reason);
  py::class_<PoseGraphSummary>(module, "PoseGraphSummary", "What became of a solve.")
      .def_readonly("status", &PoseGraphSummary::status)
      .def_readonly("message", &PoseGraphSummary::message)
      .def_readonly("initial_chi2", &PoseGraphSummary::initial_chi2)
      .def_readonly("final_chi2", &PoseGraphSummary::final_chi2)
      .def_readonly("rejected", &PoseGraphSummary::rejected);
}

}  // namespace

void BindPoseGraph(py::module_& module) {
  BindGraph(module);
  BindGraphOptions(module);
  module.def(
      "read_g2o", [](const py::object& path) { return ReadG2o(Path(path)); }, py::arg("path"));
  module.def(
      "write_g2o",
      [](const py::object& path, const PoseGraph& graph) { WriteG2o(Path(path), graph); },
      py::arg("path"), py::arg("graph"));
  module.def("chi2", &Chi2, py::arg("graph"), "Sum over all edges.");
  module.def("edge_chi2", &EdgeChi2, py::arg("graph"), "Of each edge.");
  module.def(
      "initialize_pose_graph",
      [](PoseGraph& graph, PoseGraphInitialization initialization) {
        InitializePoseGraph(&graph, initialization);
      },
      py::arg("graph"), py::arg("initialization"), "Replaces the poses of the nodes.");
  module.def(
      "solve_pose_graph",
      [](PoseGraph& graph, const PoseGraphOptions& options) {
        // Solves a copy: other threads may read or change the graph until the poses are updated.
        PoseGraph solved = graph;
        CallGate gate("PoseGraph");
        PoseGraphOptions interruptible = options;
        interruptible.solver = Interruptible(options.solver, gate);
        PoseGraphSummary summary;
        {
          const py::gil_scoped_release unlocked;
          summary = SolvePoseGraph(&solved, interruptible);
        }
        gate.RaiseInterrupt();
        graph = std::move(solved);
        return summary;
      },
      py::arg("graph"), py::arg("options") = PoseGraphOptions{},
      "Moves the poses of the nodes. Ctrl-C "
      "leaves them where they are.");
  module.def(
      "pose_graph_covariance",
      [](const PoseGraph& graph, const std::vector<std::int64_t>& ids,
         const std::vector<std::size_t>& without) {
        const PoseGraph asked = graph;  // other threads may change it
        const py::gil_scoped_release unlocked;
        return PoseGraphCovariance(asked, ids, without);
      },
      py::arg("graph"), py::arg("ids"), py::arg("without") = std::vector<std::size_t>(),
      "Joint, of nodes: [dp dtheta] in SE3, [x y theta] in SE2; None where the edges do not "
      "determine them.");
}

}  // namespace highwall::python
