#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include <highwall/core/trajectory.h>

#include "plots/plot_axes.h"
#include "plots/svg.h"

namespace highwall::apps {

// Shared parts of trajectory plots.

// Returns a non-empty range to draw, with a margin on either side.
PlotRange WithMargin(PlotRange range);

// The two axes along which trajectories extend most, in alphabetical order.
class MapProjection {
 public:
  explicit MapProjection(std::span<const Trajectory* const> trajectories);

  PlotAxes MakeAxes(const PlotAxes::Box& box) const;
  SvgPoint Map(const PlotAxes& axes, const Pose& pose) const {
    return axes.Map(pose.data()[horizontal_], pose.data()[vertical_]);
  }
  std::string HorizontalLabel() const;
  std::string VerticalLabel() const;

 private:
  std::array<PlotRange, 3> ranges_;
  std::size_t horizontal_ = 0;
  std::size_t vertical_ = 1;
};

// Draws a line through the points, or a dot if there is only one.
void DrawPiece(const std::vector<SvgPoint>& points, const SvgStroke& stroke, Svg* svg);

// Draws the trajectory, interrupted where neighbouring stamps are more than max_gap [ns] apart.
void DrawTrajectory(const MapProjection& projection, const PlotAxes& axes,
                    const Trajectory& trajectory, Stamp max_gap, const SvgStroke& stroke, Svg* svg);

// Draws a sample of the stroke and its label; returns the position of the next entry.
double DrawLegendEntry(SvgPoint at, const std::string& label, const SvgStroke& stroke, Svg* svg);

// Returns the text, with its middle omitted if it would be wider than `width` [px].
std::string Fitted(const std::string& text, double width, const SvgFont& font);

}  // namespace highwall::apps
