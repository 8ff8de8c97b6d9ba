#include "plots/plot_axes.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace highwall::apps {
namespace {

const SvgStroke kGridStroke{.color = "#e6e6e6", .width = 1.0};
const SvgStroke kFrame{.color = "#888", .width = 1.0};
constexpr double kTickLabelSize = 12.0;  // [px]
constexpr double kAxisLabelSize = 13.0;  // [px]
constexpr double kPixelsPerTick = 75.0;
constexpr double kCharacterWidth = 0.56;  // of the font size

}  // namespace

void PlotRange::Include(double value) {
  min = std::min(min, value);
  max = std::max(max, value);
}

void PlotRange::Widen(double width) {
  const double margin = 0.5 * (width - Width());
  min -= margin;
  max += margin;
}

PlotTicks MakeTicks(const PlotRange& range, double count) {
  const double raw = range.Width() / count;
  const double power = std::pow(10.0, std::floor(std::log10(raw)));
  const double digit = raw / power;
  const double step = power * (digit < 1.5 ? 1.0 : digit < 3.5 ? 2.0 : digit < 7.5 ? 5.0 : 10.0);
  const int decimals = std::max(0, static_cast<int>(-std::floor(std::log10(step) + 1e-9)));
  PlotTicks ticks;
  const double slack = 1e-9 * step;
  for (double i = std::ceil((range.min - slack) / step); i * step <= range.max + slack; ++i) {
    const double value = i * step + 0.0;  // avoids minus zero
    ticks.values.push_back(value);
    ticks.labels.push_back(decimals > 5 ? fmt::format("{:.3g}", value)
                                        : fmt::format("{:.{}f}", value, decimals));
  }
  return ticks;
}

PlotTicks MakeDecades(const PlotRange& range) {
  constexpr double kSlack = 1e-9;
  PlotTicks ticks;
  for (double power = std::ceil(std::log10(range.min) - kSlack);
       power <= std::log10(range.max) + kSlack; ++power) {
    ticks.values.push_back(std::pow(10.0, power));
    ticks.labels.push_back(fmt::format("{:g}", ticks.values.back()));
  }
  return ticks;
}

PlotAxes::PlotAxes(const Box& box, const PlotRange& x, const PlotRange& y, PlotScale scale)
    : box_(box), x_(x), y_(y), scale_(scale) {}

PlotAxes PlotAxes::WithEqualScale(const Box& box, PlotRange x, PlotRange y) {
  const double scale = std::max(x.Width() / box.width, y.Width() / box.height);
  x.Widen(scale * box.width);
  y.Widen(scale * box.height);
  return PlotAxes(box, x, y);
}

SvgPoint PlotAxes::Map(double x, double y) const {
  return {box_.left + Share(x, x_) * box_.width, box_.top + (1.0 - Share(y, y_)) * box_.height};
}

double PlotAxes::Share(double value, const PlotRange& range) const {
  if (scale_ == PlotScale::kLinear) return (value - range.min) / range.Width();
  return std::log(value / range.min) / std::log(range.max / range.min);
}

PlotTicks PlotAxes::Ticks(const PlotRange& range, double length) const {
  return scale_ == PlotScale::kLinear ? MakeTicks(range, length / kPixelsPerTick)
                                      : MakeDecades(range);
}

void PlotAxes::Draw(const std::string& x_label, const std::string& y_label, Svg* svg) const {
  DrawXAxis(x_label, svg);
  DrawYAxis(y_label, svg);
  const double right = box_.left + box_.width;
  const double bottom = box_.top + box_.height;
  svg->Polyline({{box_.left, box_.top},
                 {right, box_.top},
                 {right, bottom},
                 {box_.left, bottom},
                 {box_.left, box_.top}},
                kFrame);
}

void PlotAxes::DrawXAxis(const std::string& label, Svg* svg) const {
  const double bottom = box_.top + box_.height;
  const PlotTicks ticks = Ticks(x_, box_.width);
  for (std::size_t i = 0; i < ticks.values.size(); ++i) {
    const double x = Map(ticks.values[i], y_.min).x;
    svg->Line({x, box_.top}, {x, bottom}, kGridStroke);
    svg->Line({x, bottom}, {x, bottom + 5.0}, kFrame);
    svg->Text({x, bottom + 18.0}, ticks.labels[i],
              {.size = kTickLabelSize, .anchor = SvgAnchor::kMiddle});
  }
  svg->Text({box_.left + 0.5 * box_.width, bottom + 40.0}, label,
            {.size = kAxisLabelSize, .anchor = SvgAnchor::kMiddle});
}

void PlotAxes::DrawYAxis(const std::string& label, Svg* svg) const {
  const PlotTicks ticks = Ticks(y_, box_.height);
  std::size_t longest = 0;
  for (std::size_t i = 0; i < ticks.values.size(); ++i) {
    const double y = Map(x_.min, ticks.values[i]).y;
    svg->Line({box_.left, y}, {box_.left + box_.width, y}, kGridStroke);
    svg->Line({box_.left - 5.0, y}, {box_.left, y}, kFrame);
    svg->Text({box_.left - 8.0, y + 4.0}, ticks.labels[i],
              {.size = kTickLabelSize, .anchor = SvgAnchor::kEnd});
    longest = std::max(longest, ticks.labels[i].size());
  }
  const double room = 20.0 + kCharacterWidth * kTickLabelSize * static_cast<double>(longest);
  svg->Text({box_.left - room, box_.top + 0.5 * box_.height}, label,
            {.size = kAxisLabelSize, .anchor = SvgAnchor::kMiddle, .rotation = -90.0});
}

}  // namespace highwall::apps
