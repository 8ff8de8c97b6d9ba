#include "image_changes.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "random_fields.h"

namespace highwall::bench {
namespace {

using simulate::CounterRandom;

constexpr double kDisplayGamma = 2.2;

// Returns a table for cv::LUT: 255 f(level / 255) of every grey level, f clipped to [0, 1].
template <class Function>
cv::Mat GreyLevels(const Function& f) {
  cv::Mat table(1, 256, CV_8UC1);
  for (int level = 0; level < 256; ++level) {
    const double value = std::clamp(f(level / 255.0), 0.0, 1.0);
    table.at<std::uint8_t>(level) = static_cast<std::uint8_t>(std::lround(255.0 * value));
  }
  return table;
}

void ApplyGamma(double gamma, cv::Mat* bgr) {
  const cv::Mat table = GreyLevels([gamma](double level) { return std::pow(level, gamma); });
  cv::LUT(*bgr, table, *bgr);
}

// Returns the light of every grey level, in [0, 1].
cv::Mat LightTable() {
  cv::Mat table(1, 256, CV_32FC1);
  for (int level = 0; level < 256; ++level) {
    table.at<float>(level) = static_cast<float>(std::pow(level / 255.0, kDisplayGamma));
  }
  return table;
}

// Returns the kernel of a point that moves along a line; its sum is 1.
cv::Mat LineKernel(double pixels, double angle) {
  constexpr int kSamplesPerPixel = 8;
  const int radius = static_cast<int>(std::ceil(0.5 * pixels));
  const int samples = static_cast<int>(std::ceil(kSamplesPerPixel * pixels)) + 1;
  cv::Mat kernel = cv::Mat::zeros(2 * radius + 1, 2 * radius + 1, CV_32FC1);
  for (int i = 0; i < samples; ++i) {
    const double along = pixels * ((i + 0.5) / samples - 0.5);
    const double u = radius + along * std::cos(angle), v = radius + along * std::sin(angle);
    const int u0 = std::min(static_cast<int>(u), 2 * radius - 1);
    const int v0 = std::min(static_cast<int>(v), 2 * radius - 1);
    for (int dv = 0; dv < 2; ++dv) {
      for (int du = 0; du < 2; ++du) {
        const double share = (1.0 - std::abs(u - u0 - du)) * (1.0 - std::abs(v - v0 - dv));
        kernel.at<float>(v0 + dv, u0 + du) += static_cast<float>(share / samples);
      }
    }
  }
  return kernel;
}

double LogUniform(double low, double high, float uniform) {
  return low * std::pow(high / low, static_cast<double>(uniform));
}

}  // namespace

ImageChange MotionBlur(double pixels) {
  return [pixels, to_light = LightTable()](std::size_t frame, const CounterRandom& random,
                                           RgbdImage* image) {
    const double angle = std::numbers::pi * static_cast<double>(random.Uniform(frame));
    cv::Mat light;
    cv::LUT(image->bgr, to_light, light);
    cv::filter2D(light, light, -1, LineKernel(pixels, angle), {-1, -1}, 0.0, cv::BORDER_REFLECT);
    cv::max(light, 0.0, light);  // an FFT filter is only accurate to 1e-7
    cv::pow(light, 1.0 / kDisplayGamma, light);
    light.convertTo(image->bgr, CV_8UC3, 255.0);
  };
}

ImageChange GammaJumps(double low, double high, std::size_t spell) {
  return [=](std::size_t frame, const CounterRandom&, RgbdImage* image) {
    ApplyGamma(frame / spell % 2 == 0 ? low : high, &image->bgr);
  };
}

ImageChange RandomGamma(double low, double high) {
  return [=](std::size_t frame, const CounterRandom& random, RgbdImage* image) {
    ApplyGamma(LogUniform(low, high, random.Uniform(frame)), &image->bgr);
  };
}

ImageChange ExposureJumps(double low, double high, std::size_t spell) {
  return [=](std::size_t frame, const CounterRandom& random, RgbdImage* image) {
    const double gain = LogUniform(low, high, random.Uniform(frame / spell));
    const cv::Mat table = GreyLevels([gain](double level) {
      return std::pow(gain * std::pow(level, kDisplayGamma), 1.0 / kDisplayGamma);
    });
    cv::LUT(image->bgr, table, image->bgr);
  };
}

ImageChange ColourNoise(double sigma) {
  return [sigma](std::size_t frame, const CounterRandom& random, RgbdImage* image) {
    const cv::Mat noise = NormalField(image->bgr.size(), CV_32FC3, sigma, random.Stream(frame));
    cv::add(image->bgr, noise, image->bgr, cv::noArray(), CV_8UC3);
  };
}

ImageChange HalfCovered(std::size_t spell) {
  return [spell](std::size_t frame, const CounterRandom& random, RgbdImage* image) {
    constexpr double kBlack = 4.0, kNoise = 2.0;  // [grey levels] mean and sigma
    const auto side = (random.Bits(0) % 4 + frame / spell) % 4;
    const int width = image->bgr.cols, height = image->bgr.rows;
    cv::Rect half(0, 0, side < 2 ? width / 2 : width, side < 2 ? height : height / 2);
    if (side == 1) half.x = width - half.width;
    if (side == 3) half.y = height - half.height;
    const cv::Mat noise =
        NormalField(half.size(), CV_32FC3, kNoise, random.Stream(frame).Stream(1));
    cv::add(noise, cv::Scalar::all(kBlack), image->bgr(half), cv::noArray(), CV_8UC3);
    image->depth(half).setTo(0.0);
  };
}

}  // namespace highwall::bench
