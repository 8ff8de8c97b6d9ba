#include "plots/overlay_plot.h"

#include <algorithm>
#include <array>
#include <utility>

#include <fmt/format.h>

#include <highwall/core/stamp.h>

#include "plots/plot_axes.h"
#include "plots/svg.h"
#include "plots/trajectory_drawing.h"

namespace highwall::apps {
namespace {

constexpr double kOverlayWidth = 1240.0;  // [px], as all of the following
constexpr double kTop = 96.0, kPanel = 420.0;
constexpr PlotAxes::Box kMapBox{80.0, kTop, 500.0, kPanel};
constexpr PlotAxes::Box kErrorBox{680.0, kTop, 530.0, kPanel};
constexpr double kNameWidth = 780.0;
constexpr double kLegendTop = kTop + kPanel + 70.0, kLegendRow = 22.0;

const SvgStroke kReferenceStroke{.color = "#9a9a9a", .width = 2.2};

// The Okabe and Ito colours that are dark enough on white, repeated with other dash patterns.
SvgStroke StrokeOf(std::size_t i, double width = 1.5) {
  constexpr std::array<const char*, 6> kColours = {"#0072b2", "#d55e00", "#009e73",
                                                   "#cc79a7", "#8a6d00", "#333333"};
  constexpr std::array<const char*, 4> kDashes = {"", "8 4", "3 3", "10 3 3 3"};
  return {.color = kColours[i % kColours.size()],
          .width = width,
          .dashes = kDashes[(i + i / kColours.size()) % kDashes.size()]};
}

void DrawMap(const Trajectory& reference, const std::vector<NamedError>& estimates, Svg* svg) {
  std::vector<const Trajectory*> all = {&reference};
  for (const NamedError& estimate : estimates) all.push_back(&estimate.error.estimate);
  const MapProjection projection(all);
  const PlotAxes axes = projection.MakeAxes(kMapBox);
  axes.Draw(projection.HorizontalLabel(), projection.VerticalLabel(), svg);
  DrawTrajectory(projection, axes, reference, estimates.front().error.max_gap, kReferenceStroke,
                 svg);
  for (std::size_t i = 0; i < estimates.size(); ++i) {
    const TrajectoryError& error = estimates[i].error;
    DrawTrajectory(projection, axes, error.estimate, error.max_gap, StrokeOf(i), svg);
  }
}

void DrawErrors(const std::string& quantity, const std::vector<NamedError>& estimates, Svg* svg) {
  Stamp first = estimates.front().error.estimate.front().stamp, last = first;
  double most = 0.0;
  for (const NamedError& estimate : estimates) {
    first = std::min(first, estimate.error.estimate.front().stamp);
    last = std::max(last, estimate.error.estimate.back().stamp);
    most = std::max(most, estimate.error.statistics.max);
  }
  PlotRange time{0.0, ToSeconds(last - first)};
  if (time.Width() < 1e-9) time.Widen(1.0);
  const PlotAxes axes(kErrorBox, time, {0.0, most > 0.0 ? 1.06 * most : 1.0});
  axes.Draw("time [s]", quantity, svg);
  for (std::size_t i = 0; i < estimates.size(); ++i) {
    const TrajectoryError& error = estimates[i].error;
    const SvgStroke stroke = StrokeOf(i, 1.0);
    std::vector<SvgPoint> piece;
    Stamp before = 0;
    for (std::size_t k = 0; k < error.errors.size(); ++k) {
      const Stamp stamp = error.estimate[error.indices[k]].stamp;
      if (k > 0 && stamp - before > error.max_gap) {
        DrawPiece(std::exchange(piece, {}), stroke, svg);
      }
      piece.push_back(axes.Map(ToSeconds(stamp - first), error.errors[k]));
      before = stamp;
    }
    DrawPiece(piece, stroke, svg);
  }
}

}  // namespace

void WriteOverlayPlot(const std::filesystem::path& path, const OverlayText& text,
                      const Trajectory& reference, const std::vector<NamedError>& estimates) {
  Svg svg(kOverlayWidth, kLegendTop + kLegendRow * static_cast<double>(estimates.size() + 1));
  const SvgFont title{.size = 18.0, .color = "#111", .bold = true};
  svg.Text({kMapBox.left, 34.0}, Fitted(text.title, kOverlayWidth - 2.0 * kMapBox.left, title),
           title);
  svg.Text({kMapBox.left, 58.0}, text.subtitle, {.size = 13.0});
  DrawMap(reference, estimates, &svg);
  DrawErrors(text.quantity, estimates, &svg);
  DrawLegendEntry({kMapBox.left, kLegendTop}, "reference", kReferenceStroke, &svg);
  for (std::size_t i = 0; i < estimates.size(); ++i) {
    const double y = kLegendTop + kLegendRow * static_cast<double>(i + 1);
    const NamedError& estimate = estimates[i];
    DrawLegendEntry(
        {kMapBox.left, y},
        fmt::format("{}: rmse {:.4g}, {:.1f} % of the time", Fitted(estimate.name, kNameWidth, {}),
                    estimate.error.statistics.rmse, 100.0 * estimate.error.time_covered),
        StrokeOf(i), &svg);
  }
  svg.Write(path);
}

}  // namespace highwall::apps
