#include "simulate/materials/prints.h"

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

namespace highwall::simulate {
namespace {

// Collects patches in metres, given in doubles.
class Painter {
 public:
  explicit Painter(RandomSequence* random) : random_(random) {}

  void Paint(double s, double t, double width, double height, const Colour& colour) {
    patches_.push_back({Eigen::Vector2d(s, t).cast<float>(),
                        Eigen::Vector2d(s + width, t + height).cast<float>(), colour});
  }

  // Draws a line of words of `height` from s to s + width.
  void Write(double s, double t, double width, double height, const Colour& colour) {
    const double end = s + width;
    while (s < end) {
      const double word = std::min(end - s, height * random_->Uniform(0.8, 4.0));
      Paint(s, t, word, height, colour);
      s += word + height * 0.6;
    }
  }

  std::unique_ptr<const Texture> Finish(const Colour& background) {
    return std::make_unique<PrintTexture>(background, std::move(patches_),
                                          static_cast<std::uint32_t>(random_->Bits()));
  }

 private:
  RandomSequence* random_;
  std::vector<PrintPatch> patches_;
};

const Colour kInk = Rgb(0.08, 0.08, 0.1);
const Colour kPaper = Rgb(0.92, 0.9, 0.86);

}  // namespace

Colour RandomColour(RandomSequence* random) {
  // One strong, one weak and one free component, in any order.
  std::array<double, 3> parts = {random->Uniform(0.55, 0.85), random->Uniform(0.12, 0.3),
                                 random->Uniform(0.2, 0.7)};
  std::swap(parts[0], parts[static_cast<std::size_t>(random->Index(3))]);
  std::swap(parts[1], parts[static_cast<std::size_t>(1 + random->Index(2))]);
  return Rgb(parts[0], parts[1], parts[2]);
}

std::unique_ptr<const Texture> MakePoster(const Eigen::Vector2d& size, RandomSequence* random) {
  Painter painter(random);
  const double margin = 0.06 * size.minCoeff();
  const Eigen::Vector2d inner = size.array() - 2.0 * margin;
  painter.Paint(margin, margin, inner.x(), inner.y(), RandomColour(random));
  constexpr int kRectangles = 16;
  for (int i = 0; i < kRectangles; ++i) {
    const double largest = i < 5 ? 0.5 : 0.2;
    const double w = inner.x() * random->Uniform(0.06, largest);
    const double h = inner.y() * random->Uniform(0.06, largest);
    painter.Paint(margin + random->Uniform(0.0, inner.x() - w),
                  margin + random->Uniform(0.0, inner.y() - h), w, h,
                  i % 4 == 0 ? kInk : RandomColour(random));
  }
  const double letter = 0.05 * inner.y();
  painter.Write(2 * margin, size.y() - margin - 2 * letter, inner.x() - 2 * margin, letter, kPaper);
  return painter.Finish(kPaper);
}

std::unique_ptr<const Texture> MakeNotice(const Eigen::Vector2d& size, RandomSequence* random) {
  Painter painter(random);
  const double margin = 0.1 * size.x();
  const double line = size.y() / 16.0;
  painter.Paint(margin, size.y() - margin - line, size.x() - 2 * margin, line,
                RandomColour(random));
  for (double t = size.y() - margin - 2.5 * line; t > margin; t -= 1.3 * line) {
    painter.Write(margin, t, (size.x() - 2 * margin) * random->Uniform(0.6, 1.0), 0.55 * line,
                  kInk);
  }
  return painter.Finish(kPaper);
}

std::unique_ptr<const Texture> MakeBooks(const Eigen::Vector2d& size, RandomSequence* random) {
  Painter painter(random);
  for (double s = 0.0; s < size.x() - 0.015;) {
    const double width = std::min(size.x() - s, random->Uniform(0.02, 0.05));
    const double height = size.y() * random->Uniform(0.75, 1.0);
    painter.Paint(s, 0.0, width - 0.002, height, RandomColour(random));
    const Colour band = random->Index(2) == 0 ? kInk : kPaper;
    painter.Paint(s + 0.004, height * random->Uniform(0.1, 0.3), width - 0.01, 0.1 * height, band);
    painter.Paint(s + 0.3 * width, 0.5 * height, 0.35 * width, 0.35 * height, band);
    s += width;
  }
  return painter.Finish(kInk);
}

std::unique_ptr<const Texture> MakePanels(const Eigen::Vector2d& size, int rows, int columns,
                                          const Colour& colour, RandomSequence* random) {
  Painter painter(random);
  const double w = size.x() / columns, h = size.y() / rows;
  constexpr double kGap = 0.008;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      painter.Paint(column * w + kGap, row * h + kGap, w - 2 * kGap, h - 2 * kGap,
                    colour * static_cast<float>(random->Uniform(0.85, 1.1)));
      painter.Paint(column * w + 0.35 * w, row * h + 0.7 * h, 0.3 * w, 0.025, kInk);
    }
  }
  return painter.Finish(kInk);
}

std::unique_ptr<const Texture> MakeScreen(const Eigen::Vector2d& size, RandomSequence* random) {
  Painter painter(random);
  const double bezel = 0.02;
  painter.Paint(bezel, bezel, size.x() - 2 * bezel, size.y() - 2 * bezel, Rgb(0.15, 0.2, 0.35));
  for (int window = 0; window < 2; ++window) {
    const double w = 0.45 * size.x(), h = size.y() * random->Uniform(0.5, 0.75);
    const double s = bezel + 0.02 + window * 0.46 * size.x();
    const double t = random->Uniform(bezel + 0.02, size.y() - bezel - h);
    painter.Paint(s, t, w, h, window == 0 ? kPaper : Rgb(0.05, 0.05, 0.06));
    painter.Paint(s, t + h - 0.025, w, 0.025, RandomColour(random));
    for (double line = t + h - 0.05; line > t + 0.02; line -= 0.028) {
      painter.Write(s + 0.015, line, (w - 0.03) * random->Uniform(0.4, 1.0), 0.011,
                    window == 0 ? kInk : Rgb(0.5, 0.9, 0.5));
    }
  }
  return painter.Finish(kInk);
}

std::unique_ptr<const Texture> MakeCardboard(const Eigen::Vector2d& size, RandomSequence* random) {
  Painter painter(random);
  painter.Paint(0.44 * size.x(), 0.0, 0.12 * size.x(), size.y(), Rgb(0.78, 0.66, 0.45));
  const double w = 0.34 * size.x(), h = 0.3 * size.y();
  const double s = random->Uniform(0.03, 0.08) * size.x(), t = random->Uniform(0.3, 0.6) * size.y();
  painter.Paint(s, t, w, h, kPaper);
  for (int line = 0; line < 4; ++line) {
    painter.Write(s + 0.08 * w, t + (0.12 + 0.22 * line) * h, 0.8 * w, 0.1 * h, kInk);
  }
  painter.Paint(0.65 * size.x(), 0.15 * size.y(), 0.2 * size.x(), 0.2 * size.y(),
                RandomColour(random));
  painter.Paint(0.7 * size.x(), 0.6 * size.y(), 0.18 * size.x(), 0.22 * size.y(), kInk);
  return painter.Finish(Rgb(0.62, 0.46, 0.28));
}

}  // namespace highwall::simulate
