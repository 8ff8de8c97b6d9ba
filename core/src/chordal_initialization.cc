#include "chordal_initialization.h"

#include <algorithm>
#include <cstddef>
#include <vector>

#include <Eigen/OrderingMethods>
#include <Eigen/SVD>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>

#include "planar_pose.h"

namespace highwall::internal {
namespace {

using SparseMatrix = Eigen::SparseMatrix<double>;
using Triplet = Eigen::Triplet<double>;
constexpr int kHeld = -1;

// Index of each node in the linear systems, in an elimination order that keeps the factors sparse;
// kHeld for held nodes.
struct Elimination {
  std::vector<int> place;  // by node
  int count = 0;
};

Elimination OrderNodes(const PoseGraphTopology& topology) {
  Elimination order;
  for (const bool held : topology.held) order.place.push_back(held ? kHeld : order.count++);
  std::vector<Triplet> links;
  for (const auto& [i, j] : topology.ends) {
    const int a = order.place[i], b = order.place[j];
    if (a == kHeld || b == kHeld) continue;
    links.emplace_back(a, b, 1.0);
    links.emplace_back(b, a, 1.0);
  }
  // The ordering treats a node without a diagonal entry as dense.
  for (int k = 0; k < order.count; ++k) links.emplace_back(k, k, 1.0);
  SparseMatrix pattern(order.count, order.count);
  pattern.setFromTriplets(links.begin(), links.end());
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> turn;
  Eigen::AMDOrdering<int>()(pattern, turn);
  const Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> place = turn.inverse();
  for (int& p : order.place) {
    if (p != kHeld) p = place.indices()[p];
  }
  return order;
}

// Least squares over one block x (kRows x kColumns) for each node:
//   sum of w |M x_i - x_j + c|^2,  M orthogonal, x of held nodes known.
// Columns are independent: they are right-hand sides of one matrix.
template <int kRows, int kColumns>
class BlockLeastSquares {
 public:
  using Block = Eigen::Matrix<double, kRows, kColumns>;
  using Transform = Eigen::Matrix<double, kRows, kRows>;

  // blocks: of all nodes; those of held nodes are inputs, Solve() computes the others.
  BlockLeastSquares(const Elimination& order, std::vector<Block>* blocks)
      : order_(order),
        blocks_(*blocks),
        degree_(static_cast<std::size_t>(order.count), 0.0),
        rhs_(decltype(rhs_)::Zero(kRows * order.count, kColumns)) {}

  void Add(const PoseGraphTopology::Ends& ends, double w, const Transform& M, const Block& c) {
    const int i = order_.place[ends.i], j = order_.place[ends.j];
    if (i != kHeld) {
      degree_[static_cast<std::size_t>(i)] += w;
      const Block target = j == kHeld ? Block(blocks_[ends.j] - c) : Block(-c);
      rhs_.template middleRows<kRows>(kRows * i) += w * M.transpose() * target;
    }
    if (j != kHeld) {
      degree_[static_cast<std::size_t>(j)] += w;
      const Block target = i == kHeld ? Block(M * blocks_[ends.i] + c) : c;
      rhs_.template middleRows<kRows>(kRows * j) += w * target;
    }
    if (i == kHeld || j == kHeld) return;
    for (int row = 0; row < kRows; ++row) {
      for (int column = 0; column < kRows; ++column) {
        const int r = kRows * j + row, s = kRows * i + column;  // block (j, i) of H is -w M
        entries_.emplace_back(std::max(r, s), std::min(r, s), -w * M(row, column));
      }
    }
  }

  void Solve() {
    for (int k = 0; k < kRows * order_.count; ++k) {
      entries_.emplace_back(k, k, degree_[static_cast<std::size_t>(k / kRows)]);
    }
    SparseMatrix H(kRows * order_.count, kRows * order_.count);  // lower triangle
    H.setFromTriplets(entries_.begin(), entries_.end());
    const Eigen::SimplicialLDLT<SparseMatrix, Eigen::Lower, Eigen::NaturalOrdering<int>> ldlt(H);
    const decltype(rhs_) x = ldlt.solve(rhs_);
    for (std::size_t n = 0; n < blocks_.size(); ++n) {
      const int place = order_.place[n];
      if (place != kHeld) blocks_[n] = x.template middleRows<kRows>(kRows * place);
    }
  }

 private:
  const Elimination& order_;
  std::vector<Block>& blocks_;
  std::vector<double> degree_;
  std::vector<Triplet> entries_;
  Eigen::Matrix<double, Eigen::Dynamic, kColumns> rhs_;
};

// Returns for each edge the mean information of some components of its measurement. An edge without
// information about them gets a weight so small that it matters only where no other edge does.
std::vector<double> WeightsOf(const PoseGraph& graph, Eigen::Index first, Eigen::Index count) {
  constexpr double kNone = 1e-9;
  std::vector<double> weights;
  for (const PoseGraphEdge& edge : graph.edges) {
    weights.push_back(edge.information.diagonal().segment(first, count).mean());
  }
  const double largest = *std::ranges::max_element(weights);
  for (double& w : weights) {
    if (!(w > 0.0)) w = largest > 0.0 ? kNone * largest : 1.0;
  }
  return weights;
}

// Returns the rotation nearest to M.
template <int D>
Eigen::Matrix<double, D, D> ProjectToRotation(const Eigen::Matrix<double, D, D>& M) {
  const Eigen::JacobiSVD<Eigen::Matrix<double, D, D>> svd(
      M, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix<double, D, D> U = svd.matrixU();
  if ((U * svd.matrixV().transpose()).determinant() < 0.0) U.col(D - 1) *= -1.0;
  return U * svd.matrixV().transpose();
}

template <int D>
Eigen::Matrix<double, D, D> Rotation(const Pose& pose) {
  return pose.R().topLeftCorner<D, D>();
}

template <int D>
Pose MakePose(const Eigen::Matrix<double, D, D>& R, const Eigen::Matrix<double, D, 1>& p) {
  if constexpr (D == 2) {
    return FromPlanar({p.x(), p.y(), std::atan2(R(1, 0), R(0, 0))});
  } else {
    return Pose(Eigen::Quaterniond(R), p);
  }
}

// Eq. 4: R_i Z_R = R_j row by row, over matrices, then the rotation nearest to each.
template <int D>
std::vector<Eigen::Matrix<double, D, D>> SolveRotations(const PoseGraphTopology& topology,
                                                        const Elimination& order,
                                                        const PoseGraph& graph) {
  using Matrix = Eigen::Matrix<double, D, D>;
  std::vector<Matrix> transposed;  // x_i = R_i^T
  for (const PoseGraphNode& node : graph.nodes) {
    transposed.push_back(Rotation<D>(node.pose).transpose());
  }
  BlockLeastSquares<D, D> system(order, &transposed);
  const std::vector<double> weights = WeightsOf(graph, D, D == 2 ? 1 : 3);
  for (std::size_t e = 0; e < graph.edges.size(); ++e) {
    const PoseGraphEdge& edge = graph.edges[e];
    system.Add(topology.ends[e], weights[e], Rotation<D>(edge.Z).transpose(), Matrix::Zero());
  }
  system.Solve();
  for (std::size_t n = 0; n < transposed.size(); ++n) {
    transposed[n] = ProjectToRotation<D>(transposed[n].transpose());
  }
  return transposed;
}

template <int D>
void Initialize(const PoseGraphTopology& topology, PoseGraph* graph) {
  const Elimination order = OrderNodes(topology);
  const auto R = SolveRotations<D>(topology, order, *graph);
  using Row = Eigen::Matrix<double, 1, D>;
  std::vector<Row> p;
  for (const PoseGraphNode& node : graph->nodes) p.push_back(node.pose.p().head<D>().transpose());
  BlockLeastSquares<1, D> system(order, &p);
  const Eigen::Matrix<double, 1, 1> one(1.0);
  const std::vector<double> weights = WeightsOf(*graph, 0, D);
  for (std::size_t e = 0; e < graph->edges.size(); ++e) {  // Eq. 5: p_i + R_i z = p_j
    const PoseGraphEdge& edge = graph->edges[e];
    const Row step = (R[topology.ends[e].i] * edge.Z.p().head<D>()).transpose();
    system.Add(topology.ends[e], weights[e], one, step);
  }
  system.Solve();
  for (std::size_t n = 0; n < p.size(); ++n) {
    if (!topology.held[n]) graph->nodes[n].pose = MakePose<D>(R[n], p[n].transpose());
  }
}

}  // namespace

void InitializeChordal(const PoseGraphTopology& topology, PoseGraph* graph) {
  if (graph->space == PoseGraphSpace::kSe2) {
    Initialize<2>(topology, graph);
  } else {
    Initialize<3>(topology, graph);
  }
}

}  // namespace highwall::internal
