#include "plots/allan_plot.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "plots/plot_axes.h"
#include "plots/svg.h"

namespace highwall::apps {
namespace {

constexpr double kAllanWidth = 1240.0;  // [px], as all of the following
constexpr double kAllanHeight = 600.0;
constexpr PlotAxes::Box kGyroscopeBox{100.0, 84.0, 490.0, 440.0};
constexpr PlotAxes::Box kAccelerometerBox{720.0, 84.0, 490.0, 440.0};

const SvgStroke kFit{.color = "#2f5fa5", .width = 2.0};
const SvgStroke kWhite{.color = "#d0342c", .width = 1.2, .dashes = "6 4"};
const SvgStroke kInstability{.color = "#8a8a8a", .width = 1.2, .dashes = "2 3"};
const SvgStroke kWalk{.color = "#2a7f3f", .width = 1.2, .dashes = "9 4"};
const SvgStroke kBar{.color = "#111", .width = 1.0};

// Expands a range to full decades.
PlotRange Decades(const PlotRange& range) {
  return {std::pow(10.0, std::floor(std::log10(range.min))),
          std::pow(10.0, std::ceil(std::log10(range.max)))};
}

// Returns two standard errors of a deviation, as a factor.
double Spread(const AllanPoint& point) {
  return std::exp(std::sqrt(2.0 / point.freedom));
}

void DrawPanel(const PlotAxes::Box& box, const std::string& name, const std::string& unit,
               const SensorNoise& noise, Svg* svg) {
  PlotRange taus, deviations;
  for (const AllanPoint& point : noise.curve) {
    taus.Include(point.tau);
    deviations.Include(point.deviation);
  }
  taus = Decades(taus);
  deviations = Decades(deviations);
  const PlotAxes axes(box, taus, deviations, PlotScale::kLogarithmic);
  svg->Text({box.left, box.top - 12.0}, name, {.size = 14.0, .bold = true});
  axes.Draw("averaging time [s]", "Allan deviation [" + unit + "]", svg);

  const auto curve = [&](const NoiseDensities& densities, const SvgStroke& stroke) {
    std::vector<SvgPoint> line;
    for (double tau = taus.min; tau <= 1.0001 * taus.max; tau *= 1.1) {
      const double deviation = ModelledAllanDeviation(densities, tau);
      if (deviation < deviations.min || deviation > deviations.max) continue;
      line.push_back(axes.Map(tau, deviation));
    }
    if (!line.empty()) svg->Polyline(line, stroke);
  };
  curve({noise.all.white, {}, {}}, kWhite);
  curve({{}, noise.all.instability, {}}, kInstability);
  curve({{}, {}, noise.all.walk}, kWalk);
  curve(noise.all, kFit);
  for (const AllanPoint& point : noise.curve) {
    const auto at = [&](double deviation) {
      return axes.Map(point.tau, std::clamp(deviation, deviations.min, deviations.max));
    };
    svg->Line(at(point.deviation / Spread(point)), at(point.deviation * Spread(point)), kBar);
    svg->Circle(at(point.deviation), 3.0, "#111");
  }
}

void DrawAllanLegend(Svg* svg) {
  double left = kGyroscopeBox.left;
  const auto entry = [&](const std::string& label, const SvgStroke& stroke) {
    svg->Line({left, kAllanHeight - 16.0}, {left + 28.0, kAllanHeight - 16.0}, stroke);
    svg->Text({left + 34.0, kAllanHeight - 12.0}, label, {});
    left += 60.0 + 6.6 * static_cast<double>(label.size());
  };
  entry("fit", kFit);
  entry("white noise", kWhite);
  entry("bias instability", kInstability);
  entry("random walk of the bias", kWalk);
}

}  // namespace

void WriteAllanPlot(const std::filesystem::path& path, const std::string& title,
                    const ImuNoiseEstimate& estimate) {
  Svg svg(kAllanWidth, kAllanHeight);
  svg.Text({kGyroscopeBox.left, 34.0}, title, {.size = 18.0, .color = "#111", .bold = true});
  DrawPanel(kGyroscopeBox, "gyroscope", "rad/s", estimate.gyroscope, &svg);
  DrawPanel(kAccelerometerBox, "accelerometer", "m/s²", estimate.accelerometer, &svg);
  DrawAllanLegend(&svg);
  svg.Write(path);
}

}  // namespace highwall::apps
