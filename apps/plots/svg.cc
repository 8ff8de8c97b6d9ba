#include "plots/svg.h"

#include <cmath>
#include <utility>

#include <fmt/format.h>

#include <highwall/core/atomic_file.h>

#include "files/json_text.h"
#include "plots/map_pictures.h"
#include "plots/svg_raster.h"

namespace highwall::apps {
namespace {

std::string Escape(const std::string& text) {
  std::string escaped;
  for (const char c : ToUtf8(text)) {
    switch (c) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      default:
        escaped += c;
    }
  }
  return escaped;
}

std::string Format(const SvgStroke& stroke) {
  std::string text =
      fmt::format(R"(stroke="{}" stroke-width="{:.4g}")", stroke.color, stroke.width);
  if (!stroke.dashes.empty()) text += fmt::format(R"( stroke-dasharray="{}")", stroke.dashes);
  return text;
}

const char* Name(SvgAnchor anchor) {
  switch (anchor) {
    case SvgAnchor::kStart:
      break;
    case SvgAnchor::kMiddle:
      return "middle";
    case SvgAnchor::kEnd:
      return "end";
  }
  return "start";
}

std::string Format(const SvgRectangle& r) {
  return fmt::format(R"(<rect x="{:.2f}" y="{:.2f}" width="{:.2f}" height="{:.2f}" fill="{}"/>)"
                     "\n",
                     r.corner.x, r.corner.y, r.width, r.height, r.fill);
}

std::string Format(const SvgPolyline& line) {
  if (line.points.size() == 2) {
    const SvgPoint &a = line.points.front(), &b = line.points.back();
    return fmt::format(R"(<line x1="{:.2f}" y1="{:.2f}" x2="{:.2f}" y2="{:.2f}" {}/>)"
                       "\n",
                       a.x, a.y, b.x, b.y, Format(line.stroke));
  }
  std::string list;
  for (const SvgPoint& point : line.points) list += fmt::format("{:.2f},{:.2f} ", point.x, point.y);
  return fmt::format(
      R"(<polyline points="{}" fill="none" stroke-linejoin="round" stroke-linecap="round" {}/>)"
      "\n",
      list, Format(line.stroke));
}

std::string Format(const SvgCircle& circle) {
  return fmt::format(R"(<circle cx="{:.2f}" cy="{:.2f}" r="{:.2f}" fill="{}"/>)"
                     "\n",
                     circle.center.x, circle.center.y, circle.radius, circle.fill);
}

std::string Format(const SvgText& text) {
  const SvgFont& font = text.font;
  std::string attributes =
      fmt::format(R"(x="{:.2f}" y="{:.2f}" font-size="{:.4g}" fill="{}" text-anchor="{}")",
                  text.at.x, text.at.y, font.size, font.color, Name(font.anchor));
  if (font.bold) attributes += R"( font-weight="bold")";
  if (font.rotation != 0.0) {
    attributes += fmt::format(" transform=\"rotate({:.4g} {:.2f} {:.2f})\"", font.rotation,
                              text.at.x, text.at.y);
  }
  return fmt::format("<text {}>{}</text>\n", attributes, Escape(text.text));
}

}  // namespace

Svg::Svg(double width, double height) : width_(width), height_(height) {
  Rectangle({0.0, 0.0}, width, height, "#fff");
}

void Svg::Rectangle(SvgPoint corner, double width, double height, const std::string& fill) {
  elements_.emplace_back(SvgRectangle{corner, width, height, fill});
}

void Svg::Line(SvgPoint from, SvgPoint to, const SvgStroke& stroke) {
  elements_.emplace_back(SvgPolyline{{from, to}, stroke});
}

void Svg::Polyline(const std::vector<SvgPoint>& points, const SvgStroke& stroke) {
  constexpr double kVisible = 0.5;  // [px]
  std::vector<SvgPoint> drawn;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const bool end = i == 0 || i + 1 == points.size();
    if (!end && std::hypot(points[i].x - drawn.back().x, points[i].y - drawn.back().y) < kVisible) {
      continue;
    }
    drawn.push_back(points[i]);
  }
  elements_.emplace_back(SvgPolyline{std::move(drawn), stroke});
}

void Svg::Circle(SvgPoint center, double radius, const std::string& fill) {
  elements_.emplace_back(SvgCircle{center, radius, fill});
}

void Svg::Text(SvgPoint at, const std::string& text, const SvgFont& font) {
  elements_.emplace_back(SvgText{at, text, font});
}

void Svg::Write(const std::filesystem::path& path) const {
  if (path.extension() == ".png") return WritePng(path, Rasterize(*this, 2.0));
  AtomicFile file(path);
  file.stream() << fmt::format(
      R"(<svg xmlns="http://www.w3.org/2000/svg" width="{0}" height="{1}" )"
      R"(viewBox="0 0 {0} {1}" font-family="Helvetica, Arial, 'DejaVu Sans', sans-serif">)"
      "\n",
      width_, height_);
  for (const SvgElement& element : elements_) {
    file.stream() << std::visit([](const auto& e) { return Format(e); }, element);
  }
  file.stream() << "</svg>\n";
  file.Commit();
}

}  // namespace highwall::apps
