#include "local/corner_patch.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <ceres/tiny_solver.h>
#include <opencv2/imgproc.hpp>

namespace highwall {
namespace {

constexpr int kRadius = 4;  // [px of the level] of the compared part
constexpr int kSide = 2 * kRadius + 1;
// [px of the level] A larger shift means another corner.
constexpr double kMaxShift = 2.0;
constexpr double kMinCorrelation = 0.9;

using Window = Eigen::Matrix<double, kSide * kSide, 1>;

// (u, v): within [0, columns - 1) x [0, rows - 1); bilinear.
double Interpolate(const std::uint8_t* pixels, std::size_t step, double u, double v) {
  const auto u0 = static_cast<std::size_t>(u), v0 = static_cast<std::size_t>(v);
  const double a = u - static_cast<double>(u0), b = v - static_cast<double>(v0);
  const std::uint8_t* p = pixels + v0 * step + u0;
  const double top = p[0] + a * (p[1] - p[0]);
  const double bottom = p[step] + a * (p[step + 1] - p[step]);
  return top + b * (bottom - top);
}

bool Holds(int columns, int rows, double u, double v) {
  return u >= 0.0 && v >= 0.0 && u < columns - 1 && v < rows - 1;
}

// The patch warped to the other image, minus its mean, and its gradient there.
struct Template {
  Window values, du, dv;
};

std::optional<Template> MakeTemplate(const CornerPatch& patch, const Eigen::Matrix2d& A_level) {
  constexpr int kBorder = kRadius + 1;
  Eigen::Matrix<double, kSide + 2, kSide + 2> grey;  // with a border for the gradient
  for (int v = -kBorder; v <= kBorder; ++v) {
    for (int u = -kBorder; u <= kBorder; ++u) {
      const Eigen::Vector2d place =
          (A_level * Eigen::Vector2d(u, v) + patch.offset).array() + CornerPatch::kRadius;
      if (!Holds(CornerPatch::kSide, CornerPatch::kSide, place.x(), place.y())) return std::nullopt;
      grey(v + kBorder, u + kBorder) =
          Interpolate(patch.pixels.data(), CornerPatch::kSide, place.x(), place.y());
    }
  }
  Template made;
  for (int v = 1, i = 0; v <= kSide; ++v) {
    for (int u = 1; u <= kSide; ++u, ++i) {
      made.values(i) = grey(v, u);
      made.du(i) = 0.5 * (grey(v, u + 1) - grey(v, u - 1));
      made.dv(i) = 0.5 * (grey(v + 1, u) - grey(v - 1, u));
    }
  }
  made.values.array() -= made.values.mean();
  return made;
}

// The functor of ceres::TinySolver: image(start + d + x) - gain template(x) - mean as a function of
// (d, gain, mean). The gradient is that of the template, not of the image: noise makes a derivative
// of bilinear interpolation jump from pixel to pixel, and the solver stop short.
class GreyLevels {
 public:
  using Scalar = double;
  enum { NUM_RESIDUALS = kSide * kSide, NUM_PARAMETERS = 4 };

  GreyLevels(const cv::Mat& image, Eigen::Vector2d start, const Template& patch)
      : image_(image), start_(std::move(start)), patch_(patch) {}

  bool Contains(const Eigen::Vector2d& middle) const {
    return Holds(image_.cols, image_.rows, middle.x() - kRadius, middle.y() - kRadius) &&
           Holds(image_.cols, image_.rows, middle.x() + kRadius, middle.y() + kRadius);
  }

  bool operator()(const double* x, double* residuals, double* jacobian) const {
    const Eigen::Vector2d middle = start_ + Eigen::Map<const Eigen::Vector2d>(x);
    Eigen::Map<Window> r(residuals);
    if (!middle.allFinite() || !Contains(middle)) {
      // TinySolver ignores the return value: such a step must cost more than any.
      r.setConstant(std::numeric_limits<double>::infinity());
      return false;
    }
    r = About(middle) - x[2] * patch_.values;
    r.array() -= x[3];
    if (jacobian == nullptr) return true;
    Eigen::Map<Eigen::Matrix<double, NUM_RESIDUALS, NUM_PARAMETERS>> J(jacobian);
    J << x[2] * patch_.du, x[2] * patch_.dv, -patch_.values, Window::Constant(-1.0);
    return true;
  }

  Window About(const Eigen::Vector2d& middle) const {
    Window grey;
    for (int v = -kRadius, i = 0; v <= kRadius; ++v) {
      for (int u = -kRadius; u <= kRadius; ++u, ++i) {
        grey(i) = Interpolate(image_.data, image_.step, middle.x() + u, middle.y() + v);
      }
    }
    return grey;
  }

 private:
  const cv::Mat& image_;
  const Eigen::Vector2d start_;
  const Template& patch_;
};

}  // namespace

ImageLevels::ImageLevels(const cv::Mat& gray, const PyramidOptions& pyramid) : images_{gray} {
  for (int i = 1; i < pyramid.levels; ++i) {
    const double scale = std::pow(pyramid.scale_factor, i);
    const cv::Size size(cvRound(gray.cols / scale), cvRound(gray.rows / scale));
    if (size.width < kSide || size.height < kSide) break;
    cv::Mat image;
    cv::resize(images_.back(), image, size, 0.0, 0.0, cv::INTER_LINEAR);
    images_.push_back(image);
  }
}

Eigen::Vector2d ImageLevels::ToLevel(const Eigen::Vector2d& pixel, int octave) const {
  const cv::Mat& full = images_.front();
  const Eigen::Vector2d scale(static_cast<double>(level(octave).cols) / full.cols,
                              static_cast<double>(level(octave).rows) / full.rows);
  return ((pixel.array() + 0.5) * scale.array() - 0.5).matrix();
}

Eigen::Vector2d ImageLevels::FromLevel(const Eigen::Vector2d& place, int octave) const {
  const cv::Mat& full = images_.front();
  const Eigen::Vector2d scale(static_cast<double>(full.cols) / level(octave).cols,
                              static_cast<double>(full.rows) / level(octave).rows);
  return ((place.array() + 0.5) * scale.array() - 0.5).matrix();
}

std::optional<CornerPatch> CutPatch(const ImageLevels& image, int octave,
                                    const Eigen::Vector2d& pixel, KeyFrameId keyframe) {
  if (octave >= image.size()) return std::nullopt;
  const cv::Mat& level = image.level(octave);
  const Eigen::Vector2d place = image.ToLevel(pixel, octave);
  const cv::Point middle(cvRound(place.x()), cvRound(place.y()));
  const cv::Rect whole(0, 0, level.cols, level.rows);
  const cv::Rect square(middle.x - CornerPatch::kRadius, middle.y - CornerPatch::kRadius,
                        CornerPatch::kSide, CornerPatch::kSide);
  if ((square & whole) != square) return std::nullopt;
  CornerPatch patch;
  patch.keyframe = keyframe;
  patch.scale = image.Scale(octave);
  patch.offset = place - Eigen::Vector2d(middle.x, middle.y);
  for (int v = 0; v < CornerPatch::kSide; ++v) {
    std::copy_n(level.ptr<std::uint8_t>(square.y + v) + square.x, CornerPatch::kSide,
                patch.pixels.begin() + std::ptrdiff_t{v} * CornerPatch::kSide);
  }
  return patch;
}

std::optional<Eigen::Vector2d> AlignPatch(const CornerPatch& patch, const Eigen::Matrix2d& A,
                                          const ImageLevels& image, int octave,
                                          const Eigen::Vector2d& pixel) {
  if (octave >= image.size()) return std::nullopt;
  const cv::Mat& level = image.level(octave);
  const auto seen = MakeTemplate(patch, A * (image.Scale(octave) / patch.scale));
  if (!seen) return std::nullopt;
  const Eigen::Vector2d start = image.ToLevel(pixel, octave);
  const GreyLevels problem(level, start, *seen);
  if (!problem.Contains(start)) return std::nullopt;

  ceres::TinySolver<GreyLevels> solver;
  solver.options.max_num_iterations = 10;
  solver.options.parameter_tolerance = 1e-5;  // of a mean of some 100: a thousandth of a pixel
  Eigen::Vector4d x(0.0, 0.0, 1.0, level.at<std::uint8_t>(cvRound(start.y()), cvRound(start.x())));
  const auto& summary = solver.Solve(problem, &x);
  const Eigen::Vector2d shift = x.head<2>();
  const Eigen::Vector2d found = start + shift;
  if (!x.allFinite() || x[2] <= 0.0 || !(shift.norm() <= kMaxShift) || !problem.Contains(found)) {
    return std::nullopt;
  }
  // A linear function of the patch leaves 1 - correlation^2 of the image's variation.
  const double variation = (problem.About(found).array() - x[3]).square().sum();
  constexpr double kMostLeft = 1.0 - kMinCorrelation * kMinCorrelation;
  if (!(2.0 * summary.final_cost <= kMostLeft * variation)) return std::nullopt;
  return image.FromLevel(found, octave);
}

}  // namespace highwall
