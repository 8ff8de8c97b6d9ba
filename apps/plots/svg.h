#pragma once

#include <filesystem>
#include <string>
#include <variant>
#include <vector>

namespace highwall::apps {

// Point of the drawing [px], y down.
struct SvgPoint {
  double x = 0.0;
  double y = 0.0;
};

struct SvgStroke {
  std::string color = "#000";
  double width = 1.0;       // [px]
  std::string dashes = {};  // such as "6 4"; empty: solid
};

enum class SvgAnchor { kStart, kMiddle, kEnd };

struct SvgFont {
  double size = 12.0;  // [px]
  SvgAnchor anchor = SvgAnchor::kStart;
  std::string color = "#333";
  bool bold = false;
  double rotation = 0.0;  // [deg], clockwise about the point
};

struct SvgRectangle {
  SvgPoint corner;
  double width = 0.0, height = 0.0;
  std::string fill;
};
struct SvgPolyline {
  std::vector<SvgPoint> points;
  SvgStroke stroke;
};
struct SvgCircle {
  SvgPoint center;
  double radius = 0.0;
  std::string fill;
};
struct SvgText {
  SvgPoint at;
  std::string text;
  SvgFont font;
};
using SvgElement = std::variant<SvgRectangle, SvgPolyline, SvgCircle, SvgText>;

// Drawing that grows by elements; later ones are on top.
class Svg {
 public:
  // Size in px, white background.
  Svg(double width, double height);

  void Rectangle(SvgPoint corner, double width, double height, const std::string& fill);
  void Line(SvgPoint from, SvgPoint to, const SvgStroke& stroke);
  // Omits points closer than half a pixel to the previous one.
  void Polyline(const std::vector<SvgPoint>& points, const SvgStroke& stroke);
  void Circle(SvgPoint center, double radius, const std::string& fill);
  void Text(SvgPoint at, const std::string& text, const SvgFont& font);

  double width() const { return width_; }
  double height() const { return height_; }
  const std::vector<SvgElement>& elements() const { return elements_; }

  // Writes an SVG file, or a PNG with two pixels per px of the drawing if the name ends in .png.
  // Throws IoError.
  void Write(const std::filesystem::path& path) const;

 private:
  double width_, height_;
  std::vector<SvgElement> elements_;
};

}  // namespace highwall::apps
