// Compares pose graph optimization with a straightforward solution: AutoDiff residuals,
// SPARSE_NORMAL_CHOLESKY, the given initial values (odometry if the file has none), and Ceres'
// defaults otherwise.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

#include <ceres/autodiff_cost_function.h>
#include <ceres/problem.h>
#include <ceres/solver.h>
#include <fmt/core.h>
#include <CLI/App.hpp>
#include <Eigen/Cholesky>
#include <nlohmann/json.hpp>

#include <highwall/core/error.h>
#include <highwall/core/manifolds.h>
#include <highwall/core/pose_graph.h>

#include "bench_main.h"
#include "support/false_loops.h"
#include "timing.h"

namespace highwall {
namespace {

template <int N>
Eigen::Matrix<double, N, N> Whitening(const PoseGraphEdge& edge) {
  const Eigen::Matrix<double, N, N> information = edge.information;
  return information.llt().matrixU();
}

// W Log(Z^-1 T_i^-1 T_j) over blocks [p q].
struct SpaceResidual {
  Pose Z;
  Eigen::Matrix<double, 6, 6> W;

  template <typename T>
  bool operator()(const T* i, const T* j, T* residuals) const {
    using Vector3 = Eigen::Matrix<T, 3, 1>;
    const Eigen::Map<const Vector3> p_i(i), p_j(j);
    const Eigen::Map<const Eigen::Quaternion<T>> q_i(i + 3), q_j(j + 3);
    const Eigen::Quaternion<T> q_Z_inverse = Z.q().conjugate().cast<T>();
    Eigen::Quaternion<T> q = q_Z_inverse * (q_i.conjugate() * q_j);
    const Vector3 p = q_Z_inverse * (q_i.conjugate() * (p_j - p_i) - Z.p().cast<T>());
    if (q.w() < T(0.0)) q.coeffs() = -q.coeffs();
    using std::atan2;
    using std::cos;
    using std::sin;
    using std::sqrt;
    const T n2 = q.vec().squaredNorm();
    Eigen::Matrix<T, 6, 1> e;
    if (n2 < T(1e-12)) {
      const Vector3 theta = T(2.0) * q.vec();
      e << p - T(0.5) * theta.cross(p), theta;
    } else {
      const T n = sqrt(n2);
      const T angle = T(2.0) * atan2(n, q.w());
      const Vector3 theta = q.vec() * (angle / n);
      const T half = T(0.5) * angle;
      const T b = (T(1.0) - half * cos(half) / sin(half)) / (angle * angle);
      e << p - T(0.5) * theta.cross(p) + b * theta.cross(theta.cross(p)), theta;
    }
    Eigen::Map<Eigen::Matrix<T, 6, 1>> r(residuals);
    r = W.cast<T>() * e;
    return true;
  }
};

// W [t theta] of Z^-1 T_i^-1 T_j over blocks [x y theta].
struct PlaneResidual {
  Eigen::Vector3d Z;
  Eigen::Matrix3d W;

  template <typename T>
  bool operator()(const T* i, const T* j, T* residuals) const {
    using std::cos;
    using std::floor;
    using std::sin;
    const T dx = j[0] - i[0], dy = j[1] - i[1], c = cos(i[2]), s = sin(i[2]);
    const T x = c * dx + s * dy - T(Z[0]), y = c * dy - s * dx - T(Z[1]);
    const T c_z = T(std::cos(Z[2])), s_z = T(std::sin(Z[2]));
    const T angle = j[2] - i[2] - T(Z[2]);
    const T turn = T(2.0 * M_PI);
    Eigen::Matrix<T, 3, 1> e(c_z * x + s_z * y, c_z * y - s_z * x,
                             angle - turn * floor((angle + T(M_PI)) / turn));
    Eigen::Map<Eigen::Matrix<T, 3, 1>> r(residuals);
    r = W.cast<T>() * e;
    return true;
  }
};

struct Outcome {
  double seconds = 0.0;
  int iterations = 0;
  double chi2 = 0.0;
};

double Yaw(const Pose& pose) {
  return 2.0 * std::atan2(pose.q().z(), pose.q().w());
}

Outcome SolveStraight(const PoseGraph& graph) {
  const bool planar = graph.space == PoseGraphSpace::kSe2;
  Outcome outcome;
  ceres::Solver::Summary summary;
  outcome.seconds = bench::WallSeconds([&] {
    PoseManifold manifold;
    ceres::Problem::Options options;
    options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    ceres::Problem problem(options);
    std::map<std::int64_t, std::vector<double>> blocks;
    for (const PoseGraphNode& node : graph.nodes) {
      const Pose& pose = node.pose;
      std::vector<double>& block = blocks[node.id];
      block = planar ? std::vector<double>{pose.p().x(), pose.p().y(), Yaw(pose)}
                     : std::vector<double>(pose.data(), pose.data() + Pose::kSize);
      problem.AddParameterBlock(block.data(), static_cast<int>(block.size()),
                                planar ? nullptr : &manifold);
    }
    problem.SetParameterBlockConstant(blocks.at(graph.nodes.front().id).data());
    for (const PoseGraphEdge& edge : graph.edges) {
      ceres::CostFunction* cost;
      if (planar) {
        cost = new ceres::AutoDiffCostFunction<PlaneResidual, 3, 3, 3>(
            new PlaneResidual{{edge.Z.p().x(), edge.Z.p().y(), Yaw(edge.Z)}, Whitening<3>(edge)});
      } else {
        cost = new ceres::AutoDiffCostFunction<SpaceResidual, 6, 7, 7>(
            new SpaceResidual{edge.Z, Whitening<6>(edge)});
      }
      problem.AddResidualBlock(cost, nullptr, blocks.at(edge.i).data(), blocks.at(edge.j).data());
    }
    ceres::Solver::Options solver;
    solver.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
    solver.max_num_iterations = 100;
    solver.logging_type = ceres::SILENT;
    ceres::Solve(solver, &problem, &summary);
  });
  outcome.iterations = summary.num_successful_steps + summary.num_unsuccessful_steps;
  outcome.chi2 = 2.0 * summary.final_cost;
  return outcome;
}

Outcome SolveChordal(PoseGraph graph) {
  Outcome outcome;
  PoseGraphSummary summary;
  outcome.seconds = bench::WallSeconds([&] {
    InitializePoseGraph(&graph, PoseGraphInitialization::kChordal);
    summary = SolvePoseGraph(&graph);
  });
  outcome.iterations = summary.iterations;
  outcome.chi2 = summary.final_chi2;
  return outcome;
}

// Returns the run of median time among `runs`. The two methods alternate, so that the load of the
// machine affects both.
std::pair<Outcome, Outcome> Compare(const PoseGraph& given, int runs) {
  std::vector<Outcome> straight, chordal;
  for (int run = 0; run < runs; ++run) {
    straight.push_back(SolveStraight(given));
    chordal.push_back(SolveChordal(given));
  }
  const auto median = [](std::vector<Outcome>* outcomes) {
    const auto middle = outcomes->begin() + static_cast<std::ptrdiff_t>(outcomes->size() / 2);
    std::nth_element(outcomes->begin(), middle, outcomes->end(),
                     [](const Outcome& a, const Outcome& b) { return a.seconds < b.seconds; });
    return *middle;
  };
  return {median(&straight), median(&chordal)};
}

nlohmann::ordered_json ToJson(const Outcome& outcome) {
  return {{"seconds", outcome.seconds}, {"iterations", outcome.iterations}, {"chi2", outcome.chi2}};
}

PoseGraph ReadWithPoses(const std::filesystem::path& path) {
  PoseGraph graph = ReadG2o(path);
  if (!graph.has_poses) InitializePoseGraph(&graph, PoseGraphInitialization::kOdometry);
  return graph;
}

nlohmann::ordered_json CompareFile(const std::filesystem::path& path, int runs) {
  const auto [straight, chordal] = Compare(ReadWithPoses(path), runs);
  fmt::print(
      stderr,
      "{:<26} straight {:8.4f} s {:4} it chi2 {:<14.7g} chordal {:8.4f} s {:4} it chi2 {:<14.7g} "
      "x{:.2f}\n",
      path.stem().string(), straight.seconds, straight.iterations, straight.chi2, chordal.seconds,
      chordal.iterations, chordal.chi2, straight.seconds / chordal.seconds);
  return {{"file", path.filename().string()},
          {"straight", ToJson(straight)},
          {"chordal", ToJson(chordal)},
          {"speedup", straight.seconds / chordal.seconds}};
}

// Adds false loops to a graph, and evaluates a robust solve.
nlohmann::ordered_json RejectFalseLoops(const std::filesystem::path& path, double share,
                                        FalseLoopKind kind, unsigned seed, RobustLoops robust) {
  PoseGraph clean = ReadWithPoses(path);
  InitializePoseGraph(&clean, PoseGraphInitialization::kChordal);
  const double clean_chi2 = SolvePoseGraph(&clean).final_chi2;
  PoseGraph graph = clean;
  const std::vector<std::size_t> places = AddFalseLoops(share, kind, seed, &graph);
  PoseGraphSummary summary;
  const double seconds = bench::WallSeconds([&] {
    InitializePoseGraph(&graph, PoseGraphInitialization::kChordal);
    summary = SolvePoseGraph(&graph, {.robust = robust});
  });
  std::size_t false_rejected = 0;
  for (const RejectedLoop& loop : summary.rejected) false_rejected += loop.edge >= places.front();
  const auto loops = static_cast<std::size_t>(std::count_if(
      clean.edges.begin(), clean.edges.end(), [](const auto& e) { return e.IsLoop(); }));
  graph.edges.resize(places.front());
  const double chi2 = Chi2(graph);
  const char* const names[] = {"none", "gnc", "dcs", "switchable"};
  const std::string name = names[static_cast<int>(robust)];
  const std::string kind_name = kind == FalseLoopKind::kRandom ? "random" : "aliased";
  fmt::print(stderr,
             "{:<12} {:<8} seed {} {:<10} {:6.2f} s  chi2 over true edges {:.4f} ({:+.3f} %)  "
             "false rejected {} of {}, true {} of {}\n",
             path.stem().string(), kind_name, seed, name, seconds, chi2,
             100.0 * (chi2 / clean_chi2 - 1.0), false_rejected, places.size(),
             summary.rejected.size() - false_rejected, loops);
  return {{"file", path.filename().string()},
          {"robust", name},
          {"kind", kind_name},
          {"seed", seed},
          {"seconds", seconds},
          {"clean_chi2", clean_chi2},
          {"chi2_of_true_edges", chi2},
          {"false_loops", places.size()},
          {"false_rejected", false_rejected},
          {"true_loops", loops},
          {"true_rejected", summary.rejected.size() - false_rejected}};
}

struct Arguments {
  std::filesystem::path data;
  std::vector<std::string> files;
  int runs = 5;
  double false_loops = 0.0;
  unsigned seeds = 1;
  bool json = false;
};

void Run(const Arguments& arguments) {
  if (!std::filesystem::is_directory(arguments.data)) {
    throw IoError(arguments.data, "is not a folder");
  }
  std::set<std::filesystem::path> paths;
  for (const auto& entry : std::filesystem::directory_iterator(arguments.data)) {
    const std::string name = entry.path().stem().string();
    const bool wanted = arguments.files.empty() ||
                        std::count(arguments.files.begin(), arguments.files.end(), name) > 0;
    if (entry.path().extension() == ".g2o" && wanted) paths.insert(entry.path());
  }
  if (paths.empty()) throw IoError(arguments.data, "holds none of the wanted .g2o files");
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (const auto& path : paths) {
    if (arguments.false_loops <= 0.0) {
      rows.push_back(CompareFile(path, arguments.runs));
      continue;
    }
    for (const FalseLoopKind kind : {FalseLoopKind::kRandom, FalseLoopKind::kAliased}) {
      for (unsigned seed = 1; seed <= arguments.seeds; ++seed) {
        for (const RobustLoops robust :
             {RobustLoops::kGnc, RobustLoops::kDcs, RobustLoops::kSwitchable}) {
          rows.push_back(RejectFalseLoops(path, arguments.false_loops, kind, seed, robust));
        }
      }
    }
  }
  if (arguments.json) fmt::print("{}\n", rows.dump(1));
}

void AddOptions(CLI::App& app, Arguments& arguments) {
  app.add_option("--data", arguments.data, "Folder of .g2o files")->required();
  app.add_option("--files", arguments.files, "Names without .g2o, all if absent")->delimiter(',');
  app.add_option("--runs", arguments.runs, "Runs of each way, of which the median counts")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  app.add_option("--false-loops", arguments.false_loops,
                 "Instead: add false loops, this share of the true ones, and solve robustly")
      ->check(CLI::Range(0.0, 10.0));
  app.add_option("--seeds", arguments.seeds, "Seeds 1 to this of the false loops")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  app.add_flag("--json", arguments.json, "A JSON array on standard output");
}

}  // namespace
}  // namespace highwall

int main(int argc, char** argv) {
  highwall::Arguments arguments;
  CLI::App app(
      "Pose graphs: chordal initialization and analytic residuals against the straight way.",
      "highwall_bench_posegraph");
  highwall::AddOptions(app, arguments);
  return highwall::bench::RunBench(app, argc, argv, [&] { highwall::Run(arguments); });
}
