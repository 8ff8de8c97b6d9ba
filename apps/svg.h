#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace highwall::apps {

// A place on the drawing [px], y down.
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

// A drawing that grows element by element, later ones on top.
class Svg {
 public:
  // Size in px, white background.
  Svg(double width, double height);

  void Rectangle(SvgPoint corner, double width, double height, const std::string& fill);
  void Line(SvgPoint from, SvgPoint to, const SvgStroke& stroke);
  // Points closer than half a pixel to the one before are left out.
  void Polyline(const std::vector<SvgPoint>& points, const SvgStroke& stroke);
  void Circle(SvgPoint center, double radius, const std::string& fill);
  void Text(SvgPoint at, const std::string& text, const SvgFont& font);

  // Throws IoError.
  void Write(const std::filesystem::path& path) const;

 private:
  std::string elements_;
};

}  // namespace highwall::apps
