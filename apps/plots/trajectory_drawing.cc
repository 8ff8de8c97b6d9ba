#include "plots/trajectory_drawing.h"

#include <utility>

#include <fmt/format.h>

namespace highwall::apps {

PlotRange WithMargin(PlotRange range) {
  if (range.Width() < 1e-9) range.Widen(1.0);
  range.Widen(1.08 * range.Width());
  return range;
}

MapProjection::MapProjection(std::span<const Trajectory* const> trajectories) {
  for (const Trajectory* trajectory : trajectories) {
    for (const StampedPose& stamped : *trajectory) {
      for (std::size_t c = 0; c < 3; ++c) ranges_[c].Include(stamped.pose.data()[c]);
    }
  }
  std::size_t thin = 2;
  for (std::size_t c = 2; c-- > 0;) {
    if (ranges_[c].Width() < ranges_[thin].Width()) thin = c;
  }
  horizontal_ = thin == 0 ? 1 : 0;
  vertical_ = thin == 2 ? 1 : 2;
}

PlotAxes MapProjection::MakeAxes(const PlotAxes::Box& box) const {
  return PlotAxes::WithEqualScale(box, WithMargin(ranges_[horizontal_]),
                                  WithMargin(ranges_[vertical_]));
}

std::string MapProjection::HorizontalLabel() const {
  return fmt::format("{} [m]", "xyz"[horizontal_]);
}

std::string MapProjection::VerticalLabel() const {
  return fmt::format("{} [m]", "xyz"[vertical_]);
}

void DrawPiece(const std::vector<SvgPoint>& points, const SvgStroke& stroke, Svg* svg) {
  if (points.size() == 1) svg->Circle(points.front(), stroke.width, stroke.color);
  if (points.size() > 1) svg->Polyline(points, stroke);
}

void DrawTrajectory(const MapProjection& projection, const PlotAxes& axes,
                    const Trajectory& trajectory, Stamp max_gap, const SvgStroke& stroke,
                    Svg* svg) {
  std::vector<SvgPoint> piece;
  for (std::size_t i = 0; i < trajectory.size(); ++i) {
    if (i > 0 && trajectory[i].stamp - trajectory[i - 1].stamp > max_gap) {
      DrawPiece(std::exchange(piece, {}), stroke, svg);
    }
    piece.push_back(projection.Map(axes, trajectory[i].pose));
  }
  DrawPiece(piece, stroke, svg);
}

std::string Fitted(const std::string& text, double width, const SvgFont& font) {
  constexpr double kWidth = 0.6, kBoldWidth = 0.65;  // of a character, relative to the font size
  const auto fits =
      static_cast<std::size_t>(width / (font.size * (font.bold ? kBoldWidth : kWidth)));
  std::vector<std::size_t> characters;  // start offsets, in UTF-8
  for (std::size_t i = 0; i < text.size(); ++i) {
    if ((static_cast<unsigned char>(text[i]) & 0xc0u) != 0x80u) characters.push_back(i);
  }
  if (characters.size() <= fits) return text;
  // Names usually differ at their ends.
  const std::size_t front = fits / 3, back = fits - front - 3;
  return text.substr(0, characters[front]) + "..." +
         text.substr(characters[characters.size() - back]);
}

double DrawLegendEntry(SvgPoint at, const std::string& label, const SvgStroke& stroke, Svg* svg) {
  svg->Line({at.x, at.y - 4.0}, {at.x + 28.0, at.y - 4.0}, stroke);
  svg->Text({at.x + 34.0, at.y}, label, {});
  return at.x + 58.0 + 7.2 * static_cast<double>(label.size());
}

}  // namespace highwall::apps
