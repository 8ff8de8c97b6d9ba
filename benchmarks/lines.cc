// highwall_bench_lines: compares end points with orthonormal lines. Windows of keyframes that
// observe the segments of a generated scene with known ground truth are adjusted with either
// parameterization.
#include <CLI/App.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include <highwall/core/factor_graph.h>
#include <highwall/core/line3.h>
#include <highwall/core/prior.h>
#include <highwall/factors/line_reprojection.h>

#include "bench_main.h"
#include "cli/option_checks.h"
#include "files/json_text.h"

namespace highwall::bench {
namespace {

constexpr double kDegree = M_PI / 180.0;
constexpr double kSigmaPx = 1.0;          // [px] of u and v of an observed end
constexpr double kShortest = 30.0;        // [px] of an observed segment
constexpr int kViews = 3;                 // minimum, for every line
constexpr double kStartOff = 0.03;        // [m] per axis, of initial keyframes
constexpr double kStartTurned = kDegree;  // [rad] per axis

struct Arguments {
  int seeds = 10;
  int keyframes = 8;
  int lines = 60;
  std::vector<double> slides{5.0, 40.0};      // [px]
  std::vector<double> holds{0.01, 0.1, 1.0};  // [m]
  double noise = 1.0;
  bool times = false;
  bool json = false;
};

// Observation of line `line` in keyframe `keyframe`.
struct Sight {
  std::size_t keyframe, line;
  RgbdSegment observed;
  SegmentNoise noise;
};

// Adjustment problem with its ground truth.
struct Window {
  std::vector<Pose> keyframes, start_keyframes;  // T_WC
  std::vector<Segment3> lines, start_lines;
  std::vector<Sight> sights;
  int cut_ends = 0;  // by the image border
};

// Generates a window. Ends slide inwards along the segment by |N(0, slide)| [px] in each view;
// `noise` scales the noise of pixels and depth.
class Generator {
 public:
  Generator(int seed, double slide, double noise)
      : rng_(static_cast<std::uint64_t>(seed)), slide_(slide), noise_(noise) {}

  Window Make(int keyframes, int lines) {
    Window window;
    for (int i = 0; i < keyframes; ++i) {
      window.keyframes.push_back(OnPath(static_cast<double>(i) / (keyframes - 1)));
      Eigen::Matrix<double, 6, 1> off;
      for (int k = 0; k < 6; ++k) off[k] = (k < 3 ? kStartOff : kStartTurned) * normal_(rng_);
      window.start_keyframes.push_back(window.keyframes.back().Plus(off));
    }
    window.start_keyframes.front() = window.keyframes.front();
    while (window.lines.size() < static_cast<std::size_t>(lines)) TryLine(&window);
    return window;
  }

 private:
  // Moves one metre to the right along a curve while rotating to the left.
  static Pose OnPath(double t) {
    return Pose::FromTangent(
        {t - 0.5, 0.1 * std::sin(2.0 * M_PI * t), 0.1 * std::sin(M_PI * t)},
        {0.05 * std::sin(2.0 * M_PI * t), -0.3 * (t - 0.5), 0.05 * std::sin(M_PI * t)});
  }

  double Uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(rng_);
  }
  Eigen::Vector3d InBox(const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
    const double x = Uniform(low.x(), high.x()), y = Uniform(low.y(), high.y());
    return {x, y, Uniform(low.z(), high.z())};
  }

  // Adds a segment in front of the path if enough keyframes observe it.
  void TryLine(Window* window) {
    const Eigen::Vector3d p = InBox({-2.5, -1.8, 2.0}, {2.5, 1.8, 4.5});
    const Eigen::Vector3d along = InBox({-1.0, -1.0, -0.5}, {1.0, 1.0, 0.5}).normalized();
    const Segment3 line(p, p + Uniform(0.4, 2.0) * along);
    std::vector<Sight> sights;
    int cut_ends = 0;
    for (std::size_t i = 0; i < window->keyframes.size(); ++i) {
      auto sight = See(window->keyframes[i].Inverse() * line, &cut_ends);
      if (!sight) continue;
      sight->keyframe = i;
      sight->line = window->lines.size();
      sights.push_back(*sight);
    }
    if (sights.size() < kViews) return;
    // Initialized as in a map: from the first view's depth and the estimate of its pose.
    const Sight& first = sights.front();
    window->start_lines.push_back(
        window->start_keyframes[first.keyframe] *
        Segment3(Unproject(first.observed.s), Unproject(first.observed.e)));
    window->lines.push_back(line);
    window->sights.insert(window->sights.end(), sights.begin(), sights.end());
    window->cut_ends += cut_ends;
  }

  Eigen::Vector3d Unproject(const Eigen::Vector3d& y) const {
    return camera_.Unproject(y.head<2>(), right_.Depth(y.z()));
  }

  // Returns the part of a segment inside the image, its ends each moved inwards at random. Images
  // of a line are lines in (u, v, delta), so this is computed there.
  std::optional<Sight> See(const Segment3& line_C, int* cut_ends) {
    if (std::min(line_C.p().z(), line_C.q().z()) < 0.5) return std::nullopt;
    const Eigen::Vector3d a = projection_.Project(line_C.p()), b = projection_.Project(line_C.q());
    double begin = 0.0, end = 1.0;  // fractions from a to b
    const std::array<double, 2> size{camera_.width - 1.0, camera_.height - 1.0};
    for (int k = 0; k < 2; ++k) {
      const double at_low = -a[k] / (b[k] - a[k]);
      const double at_high = (size[static_cast<std::size_t>(k)] - a[k]) / (b[k] - a[k]);
      begin = std::max(begin, std::min(at_low, at_high));
      end = std::min(end, std::max(at_low, at_high));
    }
    const int cut = (begin > 0.0 ? 1 : 0) + (end < 1.0 ? 1 : 0);
    const double length = (b - a).head<2>().norm();
    begin += slide_ / length * std::abs(normal_(rng_));
    end -= slide_ / length * std::abs(normal_(rng_));
    if ((end - begin) * length < kShortest) return std::nullopt;
    *cut_ends += cut;
    Sight sight{};
    sight.noise.px = kSigmaPx;
    sight.observed.s = Observe(a + begin * (b - a), &sight.noise.disparity_s);
    sight.observed.e = Observe(a + end * (b - a), &sight.noise.disparity_e);
    return sight;
  }

  Eigen::Vector3d Observe(const Eigen::Vector3d& y, double* disparity_sigma) {
    *disparity_sigma = DepthNoise::Kinect().DisparitySigma(right_.Depth(y.z()), right_);
    const double u = normal_(rng_), v = normal_(rng_), delta = normal_(rng_);
    return y + noise_ * Eigen::Vector3d(kSigmaPx * u, kSigmaPx * v, *disparity_sigma * delta);
  }

  std::mt19937_64 rng_;
  std::normal_distribution<double> normal_;
  double slide_, noise_;
  PinholeCamera camera_;
  VirtualRightCamera right_;
  RgbdProjection projection_{camera_, Pose()};
};

// Parameterization of lines in the adjustment.
struct Form {
  std::string name;
  bool orthonormal = false;
  double hold = 0.0;  // [m] of the prior on end points along the line; 0: none
};

std::vector<Form> Forms(const std::vector<double>& holds) {
  std::vector<Form> forms{{.name = "orthonormal", .orthonormal = true},
                          {.name = "end points, free"}};
  for (const double hold : holds) {
    forms.push_back({.name = fmt::format("end points, held to {:g} m", hold), .hold = hold});
  }
  return forms;
}

void AddSight(FactorGraph& graph, const Sight& sight, bool depth, const RgbdProjection& projection,
              const Variable<Pose>& pose, const Variable<Segment3>& line) {
  const RgbdSegment& seen = sight.observed;
  if (depth) {
    graph.AddFactor(std::make_unique<LineReprojectionRgbd>(
                        SegmentRows(seen, sight.noise, Weighting::kCovariance), projection),
                    pose, line);
  } else {
    graph.AddFactor(
        std::make_unique<LineReprojection>(
            SegmentRows(seen.s.head<2>(), seen.e.head<2>(), sight.noise.px), projection),
        pose, line);
  }
}

void AddSight(FactorGraph& graph, const Sight& sight, bool depth, const RgbdProjection& projection,
              const Variable<Pose>& pose, const Variable<OrthonormalLine>& line) {
  const RgbdSegment& seen = sight.observed;
  if (depth) {
    graph.AddFactor(std::make_unique<OrthonormalLineReprojectionRgbd>(
                        seen, sight.noise, Weighting::kCovariance, projection),
                    pose, line);
  } else {
    graph.AddFactor(std::make_unique<OrthonormalLineReprojection>(
                        seen.s.head<2>(), seen.e.head<2>(), sight.noise.px, projection),
                    pose, line);
  }
}

// Adds a prior with sigma `hold` [m] that keeps each end point at its initial position along the
// line.
void HoldAlong(FactorGraph& graph, const Variable<Segment3>& variable, double hold) {
  const Segment3 start = graph.Value(variable);
  const Eigen::RowVector3d along = (start.q() - start.p()).normalized().transpose() / hold;
  Eigen::Matrix<double, 6, 6> W = Eigen::Matrix<double, 6, 6>::Zero();
  W.block<1, 3>(0, 0) = along;
  W.block<1, 3>(1, 3) = along;
  const std::array<VariableId, 1> ids{variable};
  const Eigen::Matrix<double, 6, 1> x_0(start.data());
  graph.AddFactorToBlocks(std::make_shared<VectorPrior<6>>(x_0, W), nullptr, ids);
}

// End points that coincide define a point instead of a line.
double Distance(const Segment3& line, const Eigen::Vector3d& x) {
  constexpr double kMet = 1e-6;  // [m]
  if (line.Length() < kMet) return (x - line.p()).norm();
  return PluckerLine::FromPoints(line.p(), line.q()).Distance(x);
}
double Distance(const OrthonormalLine& line, const Eigen::Vector3d& x) {
  return line.Plucker().Distance(x);
}

// Result of the adjustment of a window.
struct Outcome {
  double position2 = 0.0, angle2 = 0.0;  // mean squares over the free keyframes [m^2], [rad^2]
  std::vector<double> lines;             // [m] from the true ends to the estimated lines
  int shrunk = 0;                        // segments that became shorter than half
  double redundancy = 0.0;               // rows minus unknowns: expected chi-squared
  SolveSummary summary;
};

Outcome Judge(const Window& window, const FactorGraph& graph,
              const std::vector<Variable<Pose>>& poses, bool depth) {
  Outcome outcome;
  int free = 0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (graph.IsFixed(poses[i])) continue;
    const Pose off = window.keyframes[i].Inverse() * graph.Value(poses[i]);
    outcome.position2 += off.p().squaredNorm();
    outcome.angle2 += off.Angle() * off.Angle();
    ++free;
  }
  outcome.position2 /= free;
  outcome.angle2 /= free;
  // A line has 4 degrees of freedom in either form: priors along it add as many rows as unknowns.
  outcome.redundancy = (depth ? 4.0 : 2.0) * static_cast<double>(window.sights.size()) -
                       4.0 * static_cast<double>(window.lines.size()) - 6.0 * free;
  return outcome;
}

// Without depth the last keyframe is also fixed, at its true pose, to define the scale.
template <class Line, class Start>
Outcome Adjust(const Window& window, bool depth, double hold, const Start& start) {
  FactorGraph graph;
  std::vector<Variable<Pose>> poses;
  for (const Pose& pose : window.start_keyframes) poses.push_back(graph.AddVariable(pose));
  graph.Fix(poses.front());
  if (!depth) {
    graph.SetValue(poses.back(), window.keyframes.back());
    graph.Fix(poses.back());
  }
  std::vector<Variable<Line>> lines;
  for (const Segment3& line : window.start_lines) lines.push_back(graph.AddLandmark(start(line)));
  const RgbdProjection projection(PinholeCamera{}, Pose());
  for (const Sight& sight : window.sights) {
    AddSight(graph, sight, depth, projection, poses[sight.keyframe], lines[sight.line]);
  }
  if constexpr (std::is_same_v<Line, Segment3>) {
    for (const auto& line : lines) {
      if (hold > 0.0) HoldAlong(graph, line, hold);
    }
  }
  const SolveSummary summary = graph.Solve({.max_iterations = 100});
  Outcome outcome = Judge(window, graph, poses, depth);
  outcome.summary = summary;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const Line value = graph.Value(lines[i]);
    outcome.lines.push_back(Distance(value, window.lines[i].p()));
    outcome.lines.push_back(Distance(value, window.lines[i].q()));
    if constexpr (std::is_same_v<Line, Segment3>) {
      outcome.shrunk += value.Length() < 0.5 * window.start_lines[i].Length() ? 1 : 0;
    }
  }
  return outcome;
}

Outcome Adjust(const Window& window, bool depth, const Form& form) {
  if (form.orthonormal) {
    return Adjust<OrthonormalLine>(window, depth, 0.0, [](const Segment3& line) {
      return OrthonormalLine(PluckerLine::FromPoints(line.p(), line.q()));
    });
  }
  return Adjust<Segment3>(window, depth, form.hold, [](const Segment3& line) { return line; });
}

double Quantile(std::vector<double> values, double share) {
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::ranges::nth_element(values, at);
  return *at;
}

// Returns the figures of one form over all seeds; `reference`: those of the orthonormal form.
nlohmann::ordered_json Sum(const std::vector<Outcome>& outcomes,
                           const std::vector<Outcome>& reference) {
  double position2 = 0.0, angle2 = 0.0, iterations = 0.0, seconds = 0.0, chi2 = 0.0;
  int converged = 0, nearer = 0, shrunk = 0;
  std::vector<double> lines;
  for (std::size_t i = 0; i < outcomes.size(); ++i) {
    const Outcome& outcome = outcomes[i];
    position2 += outcome.position2;
    angle2 += outcome.angle2;
    iterations += outcome.summary.iterations;
    seconds += outcome.summary.seconds;
    chi2 += 2.0 * outcome.summary.final_cost / outcome.redundancy;
    converged += outcome.summary.status == SolveStatus::kConverged ? 1 : 0;
    nearer += outcome.position2 < reference[i].position2 ? 1 : 0;
    shrunk += outcome.shrunk;
    lines.insert(lines.end(), outcome.lines.begin(), outcome.lines.end());
  }
  const auto seeds = static_cast<double>(outcomes.size());
  return {{"position_mm", 1e3 * std::sqrt(position2 / seeds)},
          {"angle_deg", std::sqrt(angle2 / seeds) / kDegree},
          {"line_median_mm", 1e3 * Quantile(lines, 0.5)},
          {"line_95_mm", 1e3 * Quantile(lines, 0.95)},
          {"shrunk", 2.0 * shrunk / static_cast<double>(lines.size())},
          {"chi2_over_redundancy", chi2 / seeds},
          {"iterations", iterations / seeds},
          {"converged", converged / seeds},
          {"nearer", nearer},
          {"solve_ms", 1e3 * seconds / seeds}};
}

void PrintHeader(bool times) {
  fmt::print(
      "| depth | ends slide [px] | ends cut | form | positions [mm] | angles [deg] | lines, median "
      "[mm] | lines, 95 % [mm] | shrunk | chi² / redundancy | iterations | converged | nearer than "
      "orthonormal "
      "|{}\n"
      "|---|---|---|---|---|---|---|---|---|---|---|---|---|{}\n",
      times ? " solve [ms] |" : "", times ? "---|" : "");
}

void PrintRow(const nlohmann::ordered_json& row, bool times) {
  const auto number = [&](const char* name) { return row[name].get<double>(); };
  const bool orthonormal = row["form"] == "orthonormal";
  fmt::print(
      "| {} | {:g} | {:.0f} % | {} | {:.2f} | {:.3f} | {:.2f} | {:.1f} | {} | {:.2f} | {:.1f} | "
      "{:.0f} % | {} |",
      row["depth"].get<bool>() ? "yes" : "no", number("slide_px"), 100.0 * number("cut"),
      row["form"].get<std::string>(), number("position_mm"), number("angle_deg"),
      number("line_median_mm"), number("line_95_mm"),
      orthonormal ? "" : fmt::format("{:.1f} %", 100.0 * number("shrunk")),
      number("chi2_over_redundancy"), number("iterations"), 100.0 * number("converged"),
      orthonormal ? "" : fmt::format("{}", row["nearer"].get<int>()));
  fmt::print("{}\n", times ? fmt::format(" {:.1f} |", number("solve_ms")) : "");
}

// Adjusts the same windows with all forms.
nlohmann::ordered_json Measure(const Arguments& arguments, bool depth, double slide) {
  const std::vector<Form> forms = Forms(arguments.holds);
  std::vector<std::vector<Outcome>> outcomes(forms.size());
  double cut = 0.0, ends = 0.0;
  for (int seed = 1; seed <= arguments.seeds; ++seed) {
    const Window window =
        Generator(seed, slide, arguments.noise).Make(arguments.keyframes, arguments.lines);
    cut += window.cut_ends;
    ends += 2.0 * static_cast<double>(window.sights.size());
    for (std::size_t i = 0; i < forms.size(); ++i) {
      outcomes[i].push_back(Adjust(window, depth, forms[i]));
    }
  }
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < forms.size(); ++i) {
    nlohmann::ordered_json row{
        {"depth", depth}, {"slide_px", slide}, {"cut", cut / ends}, {"form", forms[i].name}};
    row.update(Sum(outcomes[i], outcomes.front()));
    rows.push_back(row);
  }
  return rows;
}

void Run(const Arguments& arguments) {
  nlohmann::ordered_json all = nlohmann::ordered_json::array();
  if (!arguments.json) PrintHeader(arguments.times);
  for (const bool depth : {true, false}) {
    for (const double slide : arguments.slides) {
      for (nlohmann::ordered_json row : Measure(arguments, depth, slide)) {
        if (!arguments.times) row.erase("solve_ms");
        if (!arguments.json) PrintRow(row, arguments.times);
        all.push_back(std::move(row));
      }
    }
  }
  if (arguments.json) fmt::print("{}\n", apps::JsonText(all));
}

void AddOptions(CLI::App& app, Arguments& arguments) {
  const auto add = [&](const char* name, auto& value, double min, double max, const char* help) {
    return app.add_option(name, value, help)->check(apps::Between(min, max))->capture_default_str();
  };
  add("--seeds", arguments.seeds, 1, 10000, "Windows");
  add("--keyframes", arguments.keyframes, 4, 50, "Of a window");
  add("--lines", arguments.lines, 10, 500, "Of a window");
  add("--slides", arguments.slides, 0.0, 60.0,
      "How far ends slide along the line from view to view [px]")
      ->delimiter(',');
  add("--holds", arguments.holds, 1e-3, 1e3, "Priors of ends along the line [m]")->delimiter(',');
  add("--noise", arguments.noise, 0.0, 1.0, "Times the noise of pixels and depth that is drawn");
  app.add_flag("--times", arguments.times, "Show the time of a solve");
  app.add_flag("--json", arguments.json, "Print the figures as JSON");
}

}  // namespace
}  // namespace highwall::bench

int main(int argc, char** argv) {
  using namespace highwall::bench;
  return RunBench<Arguments>(
      {"highwall_bench_lines", "Lines in adjustments: end points against the orthonormal form"},
      argc, argv, AddOptions, Run);
}
