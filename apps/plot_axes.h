#pragma once

#include <limits>
#include <string>
#include <vector>

#include "svg.h"

namespace highwall::apps {

struct PlotRange {
  double min = std::numeric_limits<double>::infinity();
  double max = -std::numeric_limits<double>::infinity();

  double Width() const { return max - min; }
  void Include(double value);
  // Grows about its middle to the given width.
  void Widen(double width);
};

// Round numbers inside the range in steps of 1, 2 or 5 times a power of ten, about `count` of them.
struct PlotTicks {
  std::vector<double> values;
  std::vector<std::string> labels;
};
PlotTicks MakeTicks(const PlotRange& range, double count);
// The powers of ten inside the range, which lies above zero.
PlotTicks MakeDecades(const PlotRange& range);

enum class PlotScale { kLinear, kLogarithmic };

// A rectangle of the drawing with two axes.
class PlotAxes {
 public:
  struct Box {
    double left = 0.0, top = 0.0, width = 0.0, height = 0.0;  // [px]
  };

  // The ranges must have a width above zero, and lie above zero on logarithmic axes.
  PlotAxes(const Box& box, const PlotRange& x, const PlotRange& y,
           PlotScale scale = PlotScale::kLinear);
  // The same with one scale on both axes: the range that needs less room is widened.
  static PlotAxes WithEqualScale(const Box& box, PlotRange x, PlotRange y);

  SvgPoint Map(double x, double y) const;
  const PlotRange& x() const { return x_; }
  // Grid, frame, ticks with their numbers, and the names of the axes.
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
