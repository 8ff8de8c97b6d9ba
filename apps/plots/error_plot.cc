#include "plots/error_plot.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "plots/colour_map.h"
#include "plots/plot_axes.h"
#include "plots/svg.h"
#include "plots/trajectory_drawing.h"

namespace highwall::apps {
namespace {

constexpr double kErrorWidth = 1240.0;  // [px], as all of the following
constexpr double kErrorHeight = 580.0;
constexpr PlotAxes::Box kPathBox{80.0, 96.0, 430.0, 420.0};
constexpr PlotAxes::Box kColorBarBox{530.0, 96.0, 14.0, 420.0};
constexpr PlotAxes::Box kErrorsBox{720.0, 96.0, 490.0, 420.0};
constexpr double kUpperLegendHeight = 66.0, kLegendHeight = 84.0;
constexpr double kTextWidth = kErrorWidth - 2.0 * kPathBox.left;
constexpr int kColorLevels = 64;
constexpr std::size_t kFew = 80;  // up to this many poses or errors are also drawn as dots

const SvgStroke kTruthStroke{.color = "#b4b4b4", .width = 1.6};
const SvgStroke kErrorStroke{.color = "#4a6fa5", .width = 1.2};
const SvgStroke kLeftStroke{.color = "#e08a1e", .width = 1.2};
const SvgStroke kMeanStroke{.color = "#1b7f5c", .width = 1.6, .dashes = "7 4"};
const SvgStroke kRmseStroke{.color = "#c8352b", .width = 1.6, .dashes = "2 3"};

std::string Color(double share) {
  const auto [r, g, b] = Viridis(share);
  return fmt::format("#{:02x}{:02x}{:02x}", std::lround(r), std::lround(g), std::lround(b));
}

std::string ErrorLabel(const ErrorPlotText& text) {
  return text.unit.empty() ? text.quantity : fmt::format("{} [{}]", text.quantity, text.unit);
}

// Range of the colour scale; all errors may be equal.
PlotRange ErrorRange(const ErrorStatistics& statistics) {
  PlotRange range{statistics.min, statistics.max};
  if (range.Width() <= 1e-12 * statistics.max) range.max = range.min + 1.0;
  return range;
}

// Returns the colour level of each matched pose, 0 (smallest error) to kColorLevels - 1 (largest):
// of its own error, or of the pair that ends at it or next after it.
std::vector<int> ErrorLevels(const TrajectoryError& result) {
  const PlotRange range = ErrorRange(result.statistics);
  std::vector<int> levels;
  std::size_t k = 0;
  for (std::size_t i = 0; i < result.estimate.size(); ++i) {
    while (k + 1 < result.indices.size() && result.indices[k] < i) ++k;
    const double share = (result.errors[k] - range.min) / range.Width();
    levels.push_back(std::clamp(static_cast<int>(share * kColorLevels), 0, kColorLevels - 1));
  }
  return levels;
}

void DrawEstimate(const MapProjection& projection, const PlotAxes& axes,
                  const TrajectoryError& result, Svg* svg) {
  const std::vector<int> levels = ErrorLevels(result);
  const auto color = [&](std::size_t i) { return Color(levels[i] / (kColorLevels - 1.0)); };
  const auto draw = [&](const std::vector<SvgPoint>& piece, std::size_t end) {
    DrawPiece(piece, {.color = color(end), .width = 2.4}, svg);
  };
  const std::size_t poses = result.estimate.size();
  std::vector<SvgPoint> piece;
  for (std::size_t i = 0; i < poses; ++i) {
    const SvgPoint point = projection.Map(axes, result.estimate[i].pose);
    if (i > 0 && result.estimate[i].stamp - result.estimate[i - 1].stamp > result.max_gap) {
      draw(std::exchange(piece, {}), i - 1);
    } else if (i > 0 && levels[i] != levels[i - 1] && piece.size() > 1) {
      const SvgPoint joint = piece.back();
      draw(std::exchange(piece, {joint}), i - 1);
    }
    piece.push_back(point);
  }
  draw(piece, poses - 1);
  for (std::size_t i = 0; i < poses && poses <= kFew; ++i) {
    svg->Circle(projection.Map(axes, result.estimate[i].pose), 3.5, color(i));
  }
}

void DrawColorBar(const ErrorPlotText& text, const ErrorStatistics& statistics, Svg* svg) {
  const PlotAxes::Box& box = kColorBarBox;
  const PlotRange range = ErrorRange(statistics);
  for (int level = 0; level < kColorLevels; ++level) {
    const double height = box.height / kColorLevels;
    // One pixel of overlap hides the seams of antialiasing.
    svg->Rectangle({box.left, box.top + box.height - (level + 1) * height}, box.width,
                   height + (level > 0 ? 1.0 : 0.0), Color(level / (kColorLevels - 1.0)));
  }
  const PlotTicks ticks = MakeTicks(range, 6.0);
  for (std::size_t i = 0; i < ticks.values.size(); ++i) {
    const double y = box.top + box.height * (range.max - ticks.values[i]) / range.Width();
    svg->Line({box.left + box.width, y}, {box.left + box.width + 5.0, y}, {.color = "#888"});
    svg->Text({box.left + box.width + 8.0, y + 4.0}, ticks.labels[i], {});
  }
  svg->Text({box.left + box.width + 66.0, box.top + 0.5 * box.height}, ErrorLabel(text),
            {.size = 13.0, .anchor = SvgAnchor::kMiddle, .rotation = -90.0});
}

void DrawMap(const ErrorPlotText& text, const Trajectory& reference, const TrajectoryError& result,
             Svg* svg) {
  const std::array both = {&reference, &result.estimate};
  const MapProjection projection(both);
  const PlotAxes axes = projection.MakeAxes(kPathBox);
  axes.Draw(projection.HorizontalLabel(), projection.VerticalLabel(), svg);
  DrawTrajectory(projection, axes, reference, result.max_gap, kTruthStroke, svg);
  DrawEstimate(projection, axes, result, svg);
  DrawColorBar(text, result.statistics, svg);
  const double next =
      DrawLegendEntry({kPathBox.left, kLegendHeight}, "reference", kTruthStroke, svg);
  DrawLegendEntry({next, kLegendHeight}, "estimate, coloured by error",
                  {.color = Color(0.25), .width = 2.4}, svg);
}

// values: one per error of the result; NaN if missing.
void DrawErrorCurve(const PlotAxes& axes, const TrajectoryError& result,
                    const std::vector<double>& values, const SvgStroke& stroke, Svg* svg) {
  const Stamp start = result.estimate.front().stamp;
  std::vector<SvgPoint> piece;
  for (std::size_t k = 0; k < values.size(); ++k) {
    if (std::isnan(values[k])) continue;
    const Stamp stamp = result.estimate[result.indices[k]].stamp;
    const SvgPoint point = axes.Map(ToSeconds(stamp - start), values[k]);
    if (values.size() <= kFew) svg->Circle(point, 3.0, stroke.color);
    if (k > 0 && stamp - result.estimate[result.indices[k - 1]].stamp > result.max_gap) {
      DrawPiece(std::exchange(piece, {}), stroke, svg);
    }
    piece.push_back(point);
  }
  DrawPiece(piece, stroke, svg);
}

void DrawErrorOverTime(const ErrorPlotText& text, const TrajectoryError& result, Svg* svg) {
  const ErrorStatistics& s = result.statistics;
  PlotRange time{0.0, ToSeconds(result.estimate.back().stamp - result.estimate.front().stamp)};
  if (time.Width() < 1e-9) time.Widen(1.0);
  const PlotAxes axes(kErrorsBox, time, {0.0, s.max > 0.0 ? 1.06 * s.max : 1.0});
  axes.Draw("time [s]", ErrorLabel(text), svg);
  DrawErrorCurve(axes, result, result.errors, kErrorStroke, svg);
  DrawErrorCurve(axes, result, text.left, kLeftStroke, svg);
  const auto draw_level = [&](double left, const char* name, double value,
                              const SvgStroke& stroke) {
    svg->Line(axes.Map(time.min, value), axes.Map(time.max, value), stroke);
    return DrawLegendEntry({left, kLegendHeight},
                           fmt::format("{} {:.4g} {}", name, value, text.unit), stroke, svg);
  };
  const double next = draw_level(kErrorsBox.left, "mean", s.mean, kMeanStroke);
  draw_level(next, "rmse", s.rmse, kRmseStroke);
  if (!text.left.empty()) {
    DrawLegendEntry({kErrorsBox.left, kUpperLegendHeight}, "without shift, scale, lever arm",
                    kLeftStroke, svg);
  }
}

}  // namespace

void WriteErrorPlot(const std::filesystem::path& path, const ErrorPlotText& text,
                    const Trajectory& reference, const TrajectoryError& result) {
  Svg svg(kErrorWidth, kErrorHeight);
  const SvgFont title{.size = 18.0, .color = "#111", .bold = true};
  svg.Text({kPathBox.left, 26.0}, Fitted(text.title, kTextWidth, title), title);
  svg.Text(
      {kPathBox.left, 46.0},
      fmt::format("{}; {} poses matched over {:.1f} % of the time, scale {:.4f}", text.subtitle,
                  result.estimate.size(), 100.0 * result.time_covered, result.scale),
      {.size = 13.0});
  DrawMap(text, reference, result, &svg);
  DrawErrorOverTime(text, result, &svg);
  svg.Write(path);
}

}  // namespace highwall::apps
