#include "svg.h"

#include <cmath>

#include <fmt/format.h>

#include <highwall/core/atomic_file.h>

namespace highwall::apps {
namespace {

std::string Escape(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
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

}  // namespace

Svg::Svg(double width, double height)
    : elements_(fmt::format(
          R"(<svg xmlns="http://www.w3.org/2000/svg" width="{0}" height="{1}" )"
          R"(viewBox="0 0 {0} {1}" font-family="Helvetica, Arial, 'DejaVu Sans', sans-serif">)"
          "\n",
          width, height)) {
  Rectangle({0.0, 0.0}, width, height, "#fff");
}

void Svg::Rectangle(SvgPoint corner, double width, double height, const std::string& fill) {
  elements_ +=
      fmt::format(R"(<rect x="{:.2f}" y="{:.2f}" width="{:.2f}" height="{:.2f}" fill="{}"/>)"
                  "\n",
                  corner.x, corner.y, width, height, fill);
}

void Svg::Line(SvgPoint from, SvgPoint to, const SvgStroke& stroke) {
  elements_ += fmt::format(R"(<line x1="{:.2f}" y1="{:.2f}" x2="{:.2f}" y2="{:.2f}" {}/>)"
                           "\n",
                           from.x, from.y, to.x, to.y, Format(stroke));
}

void Svg::Polyline(const std::vector<SvgPoint>& points, const SvgStroke& stroke) {
  constexpr double kVisible = 0.5;  // [px]
  std::string list;
  SvgPoint drawn;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const bool end = i == 0 || i + 1 == points.size();
    if (!end && std::hypot(points[i].x - drawn.x, points[i].y - drawn.y) < kVisible) continue;
    drawn = points[i];
    list += fmt::format("{:.2f},{:.2f} ", drawn.x, drawn.y);
  }
  elements_ += fmt::format(
      R"(<polyline points="{}" fill="none" stroke-linejoin="round" stroke-linecap="round" {}/>)"
      "\n",
      list, Format(stroke));
}

void Svg::Circle(SvgPoint center, double radius, const std::string& fill) {
  elements_ += fmt::format(R"(<circle cx="{:.2f}" cy="{:.2f}" r="{:.2f}" fill="{}"/>)"
                           "\n",
                           center.x, center.y, radius, fill);
}

void Svg::Text(SvgPoint at, const std::string& text, const SvgFont& font) {
  std::string attributes =
      fmt::format(R"(x="{:.2f}" y="{:.2f}" font-size="{:.4g}" fill="{}" text-anchor="{}")", at.x,
                  at.y, font.size, font.color, Name(font.anchor));
  if (font.bold) attributes += R"( font-weight="bold")";
  if (font.rotation != 0.0) {
    attributes +=
        fmt::format(" transform=\"rotate({:.4g} {:.2f} {:.2f})\"", font.rotation, at.x, at.y);
  }
  elements_ += fmt::format("<text {}>{}</text>\n", attributes, Escape(text));
}

void Svg::Write(const std::filesystem::path& path) const {
  AtomicFile file(path);
  file.stream() << elements_ << "</svg>\n";
  file.Commit();
}

}  // namespace highwall::apps
