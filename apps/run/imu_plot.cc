#include "run/imu_plot.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <highwall/core/stamp.h>

#include "plots/plot_axes.h"
#include "plots/svg.h"

namespace highwall::apps {
namespace {

constexpr double kImuWidth = 1240.0, kImuHeight = 640.0;  // [px], as all of the following
constexpr PlotAxes::Box kWeightBox{100.0, 84.0, 1100.0, 200.0};
constexpr PlotAxes::Box kInnovationBox{100.0, 364.0, 1100.0, 200.0};
constexpr double kLeast = 1e-3, kMost = 1e3;  // clamping range of the values
const SvgStroke kCurve{.color = "#2f5fa5", .width = 1.2};
const SvgStroke kExpected{.color = "#8a8a8a", .width = 1.0, .dashes = "6 4"};

// Draws one value per interval, 0 if missing, with its logarithm (PlotScale::kLogarithmic applies
// to both axes) and a mark at 1.
void DrawPanel(const PlotAxes::Box& box, const std::string& name,
               const std::vector<double>& seconds, const std::vector<double>& values, Svg* svg) {
  PlotRange x{seconds.front(), seconds.back()}, y;
  if (x.Width() <= 0.0) x.Widen(1.0);
  y.Include(0.0);
  for (const double value : values) {
    if (value > 0.0) y.Include(std::log10(std::clamp(value, kLeast, kMost)));
  }
  y.Widen(1.1 * std::max(y.Width(), 0.2));
  const PlotAxes axes(box, x, y);
  svg->Text({box.left, box.top - 12.0}, name, {.size = 14.0, .bold = true});
  axes.Draw("time [s]", "power of ten", svg);
  svg->Line(axes.Map(x.min, 0.0), axes.Map(x.max, 0.0), kExpected);
  std::vector<SvgPoint> line;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!(values[i] > 0.0)) continue;
    line.push_back(axes.Map(seconds[i], std::log10(std::clamp(values[i], kLeast, kMost))));
  }
  if (line.size() > 1) svg->Polyline(line, kCurve);
}

}  // namespace

void WriteImuPlot(const std::filesystem::path& path, const InertialSummary& inertial) {
  std::vector<double> seconds, weights, innovations;
  for (const WeighedInterval& interval : inertial.intervals) {
    seconds.push_back(ToSeconds(interval.end - inertial.intervals.front().end));
    weights.push_back(interval.weight);
    innovations.push_back(interval.innovation.value_or(0.0));
  }
  Svg svg(kImuWidth, kImuHeight);
  svg.Text({kWeightBox.left, 34.0}, "The IMU from image to image",
           {.size = 18.0, .color = "#111", .bold = true});
  DrawPanel(kWeightBox, "weight of its residuals", seconds, weights, &svg);
  DrawPanel(kInnovationBox, "squared innovation a degree of freedom", seconds, innovations, &svg);
  svg.Write(path);
}

}  // namespace highwall::apps
