#include "plots/posegraph_plot.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "plots/plot_axes.h"
#include "plots/svg.h"

namespace highwall::apps {
namespace {

constexpr double kGraphWidth = 1240.0;  // [px], as all of the following
constexpr double kGraphHeight = 640.0;
constexpr PlotAxes::Box kBeforeBox{80.0, 96.0, 500.0, 480.0};
constexpr PlotAxes::Box kAfterBox{710.0, 96.0, 500.0, 480.0};

const SvgStroke kOdometryStroke{.color = "#2f5fa5", .width = 1.4};
const SvgStroke kLoopStroke{.color = "#b9b9b9", .width = 0.7};
const SvgStroke kRejectedStroke{.color = "#d0342c", .width = 0.5};

// Returns the two coordinates of largest extent, in alphabetical order.
std::array<int, 2> ChooseView(const PoseGraph& graph) {
  std::array<PlotRange, 3> ranges;
  for (const PoseGraphNode& node : graph.nodes) {
    if (node.id == graph.world) continue;
    for (int c = 0; c < 3; ++c) ranges[static_cast<std::size_t>(c)].Include(node.pose.data()[c]);
  }
  int thin = 2;
  for (int c = 1; c >= 0; --c) {
    if (ranges[static_cast<std::size_t>(c)].Width() <
        ranges[static_cast<std::size_t>(thin)].Width()) {
      thin = c;
    }
  }
  return {thin == 0 ? 1 : 0, thin == 2 ? 1 : 2};
}

PlotRange RangeOf(const PoseGraph& graph, int coordinate) {
  PlotRange range;
  for (const PoseGraphNode& node : graph.nodes) {
    if (node.id != graph.world) range.Include(node.pose.data()[coordinate]);
  }
  if (range.Width() < 1e-9) range.Widen(1.0);
  range.Widen(1.08 * range.Width());
  return range;
}

void DrawPanel(const PlotAxes::Box& box, const std::array<int, 2>& view, const PoseGraph& graph,
               const std::vector<bool>& rejected, Svg* svg) {
  const PlotAxes axes =
      PlotAxes::WithEqualScale(box, RangeOf(graph, view[0]), RangeOf(graph, view[1]));
  const auto label = [](int coordinate) { return std::string(1, "xyz"[coordinate]) + " [m]"; };
  axes.Draw(label(view[0]), label(view[1]), svg);
  std::unordered_map<std::int64_t, SvgPoint> points;
  for (const PoseGraphNode& node : graph.nodes) {
    points[node.id] = axes.Map(node.pose.data()[view[0]], node.pose.data()[view[1]]);
  }
  const auto draw = [&](const SvgStroke& stroke, bool loops, bool only_rejected) {
    for (std::size_t e = 0; e < graph.edges.size(); ++e) {
      const PoseGraphEdge& edge = graph.edges[e];
      if (edge.IsLoop() != loops || rejected[e] != only_rejected) continue;
      if (edge.i == graph.world) continue;  // a prior
      svg->Line(points.at(edge.i), points.at(edge.j), stroke);
    }
  };
  draw(kRejectedStroke, true, true);
  draw(kLoopStroke, true, false);
  draw(kOdometryStroke, false, false);
}

void DrawGraphLegend(Svg* svg) {
  double left = kBeforeBox.left;
  const auto entry = [&](const std::string& label, const SvgStroke& stroke) {
    svg->Line({left, kGraphHeight - 18.0}, {left + 28.0, kGraphHeight - 18.0}, stroke);
    svg->Text({left + 34.0, kGraphHeight - 14.0}, label, {});
    left += 60.0 + 6.6 * static_cast<double>(label.size());
  };
  entry("odometry", kOdometryStroke);
  entry("loops", kLoopStroke);
  entry("rejected loops", kRejectedStroke);
}

}  // namespace

void WritePoseGraphPlot(const std::filesystem::path& path, const PoseGraphPlotText& text,
                        const PoseGraph& before, const PoseGraph& after,
                        const PoseGraphSummary& summary) {
  Svg svg(kGraphWidth, kGraphHeight);
  svg.Text({kBeforeBox.left, 30.0}, text.title, {.size = 18.0, .color = "#111", .bold = true});
  svg.Text({kBeforeBox.left, 76.0}, text.before, {.size = 13.0});
  svg.Text({kAfterBox.left, 76.0}, text.after, {.size = 13.0});
  std::vector<bool> rejected(after.edges.size(), false);
  for (const RejectedLoop& loop : summary.rejected) rejected[loop.edge] = true;
  const std::array<int, 2> view = ChooseView(after);
  DrawPanel(kBeforeBox, view, before, rejected, &svg);
  DrawPanel(kAfterBox, view, after, rejected, &svg);
  DrawGraphLegend(&svg);
  svg.Write(path);
}

}  // namespace highwall::apps
