#include "plots/svg_raster.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <opencv2/imgproc.hpp>

#include <highwall/internal/number_text.h>

namespace highwall::apps {
namespace {

constexpr int kShift = 4;             // fractional bits of pixel coordinates in OpenCV
constexpr double kLetterHeight = 29;  // [px] of FONT_HERSHEY_SIMPLEX at scale 1, as a font size

// Parses "#rgb" or "#rrggbb".
cv::Scalar Colour(const std::string& text) {
  const std::string digits = text.substr(1);
  const std::size_t width = digits.size() / 3;
  const auto channel = [&](std::size_t i) {
    const std::string hex = digits.substr(i * width, width);
    return static_cast<double>(std::stoi(width == 1 ? hex + hex : hex, nullptr, 16));
  };
  return {channel(2), channel(1), channel(0)};
}

// Splits a line into its dashes.
std::vector<std::vector<SvgPoint>> Dashed(const std::vector<SvgPoint>& points,
                                          const std::string& dashes) {
  TextReader stream(dashes);
  double on = 0.0, off = 0.0;
  if (!(stream >> on >> off) || on + off <= 0.0) return {points};
  std::vector<std::vector<SvgPoint>> pieces;
  double at = 0.0;  // along the pattern
  for (std::size_t i = 1; i < points.size(); ++i) {
    const SvgPoint &a = points[i - 1], &b = points[i];
    const double length = std::hypot(b.x - a.x, b.y - a.y);
    const auto between = [&](double s) {
      return SvgPoint{a.x + (b.x - a.x) * s / length, a.y + (b.y - a.y) * s / length};
    };
    for (double s = 0.0; s < length;) {
      const bool drawn = at < on;
      const double step = std::min((drawn ? on : on + off) - at, length - s);
      if (drawn) {
        const bool joins = s == 0.0 && at > 0.0 && !pieces.empty();
        if (!joins) pieces.push_back({between(s)});
        pieces.back().push_back(between(s + step));
      }
      s += step;
      at += step;
      if (at >= on + off - 1e-9) at = 0.0;
    }
  }
  return pieces;
}

class SvgPainter {
 public:
  SvgPainter(const Svg& svg, double scale)
      : image_(static_cast<int>(std::lround(scale * svg.height())),
               static_cast<int>(std::lround(scale * svg.width())), CV_8UC3,
               cv::Scalar(255, 255, 255)),
        scale_(scale) {}

  void operator()(const SvgRectangle& r) {
    cv::rectangle(image_, At(r.corner), At({r.corner.x + r.width, r.corner.y + r.height}),
                  Colour(r.fill), cv::FILLED, cv::LINE_AA, kShift);
  }
  void operator()(const SvgPolyline& line) {
    const int width = std::max(1, static_cast<int>(std::lround(scale_ * line.stroke.width)));
    for (const std::vector<SvgPoint>& piece : Dashed(line.points, line.stroke.dashes)) {
      std::vector<cv::Point> points;
      for (const SvgPoint& point : piece) points.push_back(At(point));
      cv::polylines(image_, points, false, Colour(line.stroke.color), width, cv::LINE_AA, kShift);
    }
  }
  void operator()(const SvgCircle& circle) {
    cv::circle(image_, At(circle.center),
               static_cast<int>(std::lround(scale_ * circle.radius * (1 << kShift))),
               Colour(circle.fill), cv::FILLED, cv::LINE_AA, kShift);
  }
  // Draws on a mask first, which is rotated with the text.
  void operator()(const SvgText& text) {
    const double size = scale_ * text.font.size / kLetterHeight;
    const int thickness =
        std::max(1, static_cast<int>(std::lround(scale_ * (text.font.bold ? 1.5 : 0.8))));
    int below = 0;
    const cv::Size box =
        cv::getTextSize(text.text, cv::FONT_HERSHEY_SIMPLEX, size, thickness, &below);
    const double anchor = text.font.anchor == SvgAnchor::kStart    ? 0.0
                          : text.font.anchor == SvgAnchor::kMiddle ? 0.5
                                                                   : 1.0;
    const cv::Point2d at(scale_ * text.at.x, scale_ * text.at.y);
    const cv::Point begin(static_cast<int>(std::lround(at.x - anchor * box.width)),
                          static_cast<int>(std::lround(at.y)));
    if (text.font.rotation == 0.0) {
      cv::putText(image_, text.text, begin, cv::FONT_HERSHEY_SIMPLEX, size, Colour(text.font.color),
                  thickness, cv::LINE_AA);
      return;
    }
    const int margin = 2 * thickness + below;
    cv::Mat level(box.height + 2 * margin, box.width + 2 * margin, CV_8UC1, cv::Scalar(0));
    cv::putText(level, text.text, {margin, margin + box.height}, cv::FONT_HERSHEY_SIMPLEX, size,
                cv::Scalar(255), thickness, cv::LINE_AA);
    // Moves the mask to the anchor, rotated about it.
    const cv::Point2d center(margin + anchor * box.width, margin + box.height);
    cv::Mat turn = cv::getRotationMatrix2D(cv::Point2f(center), -text.font.rotation, 1.0), mask;
    turn.at<double>(0, 2) += at.x - center.x;
    turn.at<double>(1, 2) += at.y - center.y;
    cv::warpAffine(level, mask, turn, image_.size());
    cv::Mat ink(image_.size(), CV_8UC3, Colour(text.font.color));
    Blend(ink, mask);
  }
  cv::Mat image() const { return image_; }

 private:
  cv::Point At(const SvgPoint& point) const {
    return {static_cast<int>(std::lround(scale_ * point.x * (1 << kShift))),
            static_cast<int>(std::lround(scale_ * point.y * (1 << kShift)))};
  }
  void Blend(const cv::Mat& ink, const cv::Mat& mask) {
    for (int row = 0; row < image_.rows; ++row) {
      for (int column = 0; column < image_.cols; ++column) {
        const int share = mask.at<unsigned char>(row, column);
        if (share == 0) continue;
        auto& pixel = image_.at<cv::Vec3b>(row, column);
        const auto& colour = ink.at<cv::Vec3b>(row, column);
        for (int c = 0; c < 3; ++c) {
          pixel[c] =
              static_cast<unsigned char>((share * colour[c] + (255 - share) * pixel[c]) / 255);
        }
      }
    }
  }

  cv::Mat image_;
  double scale_;
};

}  // namespace

cv::Mat Rasterize(const Svg& svg, double scale) {
  SvgPainter canvas(svg, scale);
  for (const SvgElement& element : svg.elements()) std::visit(canvas, element);
  return canvas.image();
}

}  // namespace highwall::apps
