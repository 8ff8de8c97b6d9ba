#pragma once

#include <limits>
#include <string>
#include <vector>

#include "plots/svg.h"

namespace highwall::apps {

struct PlotRange {
  double min = std::numeric_limits<double>::infinity();
  double max = -std::numeric_limits<double>::infinity();

  double Width() const { return max - min; }
  void Include(double value);
  // Widens the range symmetrically to the given width.
  void Widen(double width);
};

// Axis ticks: about `count` round numbers inside the range in steps of 1, 2 or 5 times a power of
// ten.
struct PlotTicks {
  std::vector<double> values;
  std::vector<std::string> labels;
};
PlotTicks MakeTicks(const PlotRange& range, double count);
// Returns the powers of ten inside the range, which must be positive.
PlotTicks MakeDecades(const PlotRange& range);

enum class PlotScale { kLinear, kLogarithmic };

// Rectangle of the drawing with two axes.
class PlotAxes {
 public:
  struct Box {
    double left = 0.0, top = 0.0, width = 0.0, height = 0.0;  // [px]
  };

  // The ranges must have a positive width, and be positive on logarithmic axes.
  PlotAxes(const Box& box, const PlotRange& x, const PlotRange& y,
           PlotScale scale = PlotScale::kLinear);
  // Returns axes with equal scale: the range that needs less room is widened.
  static PlotAxes WithEqualScale(const Box& box, PlotRange x, PlotRange y);

  SvgPoint Map(double x, double y) const;
  const PlotRange& x() const { return x_; }
  // Draws the grid, the frame, ticks with their numbers, and the axis labels.
  void Draw(const std::string& x_label, const std::string& y_label, Svg* svg) const;

 private:
  double Share(double value, const PlotRange& range) const;  // 0 at its start, 1 at its end
  PlotTicks Ticks(const PlotRange& range, double length) const;
  void DrawXAxis(const std::string& label, Svg* svg) const;
  void DrawYAxis(const std::string& label, Svg* svg) const;

  Box box_;
  PlotRange x_;
  PlotRange y_;
  PlotScale scale_;
};

}  // namespace highwall::apps
