#pragma once

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include <opencv2/core.hpp>
#include <opencv2/dnn.hpp>
#include <opencv2/imgproc.hpp>

#include <highwall/core/error.h>
#include <highwall/frontend/features/point_extractor.h>

struct NetworkPointOptions {
  std::string name = "network";  // maps of points by another name are refused
  int features = 1000;           // most points of an image
  float threshold = 0.015F;      // of the probability of a point, (0, 1)
  // [px] > 0, within which the most probable one alone is kept; none is nearer to the border, where
  // a network sees what it is padded with.
  int radius = 4;
};

// Points by a network that is built as SuperPoint is (DeTone, Malisiewicz, Rabinovich 2018), from
// an ONNX file that the user has. For an image of H x W, multiples of 8, it is to have
//   input          1 x 1 x H x W     grey, 0 to 1
//   heat map       1 x 65 x H/8 x W/8  scores before their softmax: of the 64 pixels of a cell, row
//                                      by row, and last of "no point here"
//   descriptors    1 x D x H/8 x W/8   one a cell, at its centre
// in any order; the one with 65 channels is the heat map.
class NetworkPoints final : public highwall::PointExtractor {
 public:
  // Throws highwall::IoError where the file is no such network.
  explicit NetworkPoints(const std::filesystem::path& onnx, const NetworkPointOptions& options = {})
      : options_(options), path_(onnx) {
    try {
      net_ = cv::dnn::readNetFromONNX(onnx.string());
    } catch (const cv::Exception&) {
      throw highwall::IoError(onnx, "cannot be read as a network in ONNX");
    }
    kind_ = {.name = options.name,
             .descriptor = highwall::DescriptorType::kFloat,
             .columns = Forward(cv::Mat::zeros(64, 64, CV_8U)).descriptors.size[1],
             // The network knows no scale: a point seen from half or twice the distance is still
             // similar.
             .pyramid = {.levels = 1, .scale_factor = 2.0}};
  }

  const highwall::FeatureType& kind() const override { return kind_; }

  highwall::ExtractedPoints Extract(const cv::Mat& gray) override {
    cv::Mat padded;
    const auto up_to_cell = [](int size) { return (kCell - size % kCell) % kCell; };
    cv::copyMakeBorder(gray, padded, 0, up_to_cell(gray.rows), 0, up_to_cell(gray.cols),
                       cv::BORDER_REPLICATE);
    const Outputs outputs = Forward(padded);
    highwall::ExtractedPoints points;
    points.keypoints = Peaks(HeatMap(outputs.scores), gray.size());
    points.descriptors.create(static_cast<int>(points.keypoints.size()), kind_.columns, CV_32F);
    for (int i = 0; i < points.descriptors.rows; ++i) {
      Describe(outputs.descriptors, points.keypoints[static_cast<std::size_t>(i)].pt,
               points.descriptors.ptr<float>(i));
    }
    return points;
  }

 private:
  static constexpr int kCell = 8;                    // [px]
  static constexpr int kScores = kCell * kCell + 1;  // of a cell
  struct Outputs {
    cv::Mat scores, descriptors;
  };

  Outputs Forward(const cv::Mat& gray) {
    std::vector<cv::Mat> outputs;
    try {
      net_.setInput(cv::dnn::blobFromImage(gray, 1.0 / 255.0));
      net_.forward(outputs, net_.getUnconnectedOutLayersNames());
    } catch (const cv::Exception& error) {
      throw highwall::IoError(path_, "does not run on a grey image: " + error.err);
    }
    const auto is_map = [&](const cv::Mat& output) {
      return output.dims == 4 && output.size[2] == gray.rows / kCell &&
             output.size[3] == gray.cols / kCell;
    };
    if (outputs.size() == 2 && is_map(outputs[0]) && is_map(outputs[1])) {
      if (outputs[0].size[1] == kScores) return {outputs[0], outputs[1]};
      if (outputs[1].size[1] == kScores) return {outputs[1], outputs[0]};
    }
    throw highwall::IoError(path_,
                            "has not two outputs, of 65 scores and a descriptor for each "
                            "cell of 8 x 8 pixels");
  }

  // The probability of a point in each pixel.
  static cv::Mat HeatMap(const cv::Mat& scores) {
    cv::Mat heat(scores.size[2] * kCell, scores.size[3] * kCell, CV_32F);
    const auto score = [&](int channel, int row, int column) {
      const int index[] = {0, channel, row, column};
      return scores.at<float>(index);
    };
    for (int row = 0; row < scores.size[2]; ++row) {
      for (int column = 0; column < scores.size[3]; ++column) {
        float most = -std::numeric_limits<float>::infinity(), sum = 0.0F;
        for (int c = 0; c < kScores; ++c) most = std::max(most, score(c, row, column));
        for (int c = 0; c < kScores; ++c) sum += std::exp(score(c, row, column) - most);
        for (int c = 0; c + 1 < kScores; ++c) {
          heat.at<float>(row * kCell + c / kCell, column * kCell + c % kCell) =
              std::exp(score(c, row, column) - most) / sum;
        }
      }
    }
    return heat;
  }

  // The most probable pixels, to a fraction of them, the first the most probable.
  std::vector<cv::KeyPoint> Peaks(const cv::Mat& heat, const cv::Size& image) const {
    cv::Mat highest;
    const int side = 2 * options_.radius + 1;
    cv::dilate(heat, highest, cv::Mat::ones(side, side, CV_8U));
    std::vector<cv::KeyPoint> peaks;
    for (int y = options_.radius; y + options_.radius < image.height; ++y) {
      for (int x = options_.radius; x + options_.radius < image.width; ++x) {
        const float p = heat.at<float>(y, x);
        if (p < options_.threshold || p < highest.at<float>(y, x)) continue;
        // The next cell has a softmax of its own.
        const auto is_inside = [](int pixel) { return pixel % kCell % (kCell - 1) != 0; };
        cv::Point2f offset(0.0F, 0.0F);
        if (is_inside(x)) offset.x = Vertex(heat.at<float>(y, x - 1), p, heat.at<float>(y, x + 1));
        if (is_inside(y)) offset.y = Vertex(heat.at<float>(y - 1, x), p, heat.at<float>(y + 1, x));
        const cv::Point2f at = cv::Point2f(static_cast<float>(x), static_cast<float>(y)) + offset;
        peaks.emplace_back(at, static_cast<float>(kCell), -1.0F, p);  // without orientation
      }
    }
    std::stable_sort(peaks.begin(), peaks.end(), [](const cv::KeyPoint& a, const cv::KeyPoint& b) {
      return a.response > b.response;
    });
    peaks.resize(std::min(peaks.size(), static_cast<std::size_t>(options_.features)));
    return peaks;
  }

  // Of the parabola through three values at -1, 0 and 1, the middle one the highest.
  static float Vertex(float left, float middle, float right) {
    const float bend = left - 2.0F * middle + right;
    return bend < 0.0F ? std::clamp(0.5F * (left - right) / bend, -0.5F, 0.5F) : 0.0F;
  }

  // Between the four cells around the point.
  static void Describe(const cv::Mat& descriptors, const cv::Point2f& at, float* descriptor) {
    const auto split = [](float pixel, int cells, int* first) {
      const float cell =
          std::clamp((pixel + 0.5F) / kCell - 0.5F, 0.0F, static_cast<float>(cells - 1));
      *first = std::min(static_cast<int>(cell), std::max(cells - 2, 0));
      return cell - static_cast<float>(*first);
    };
    int row = 0, column = 0;
    const int rows = descriptors.size[2], columns = descriptors.size[3];
    const float down = split(at.y, rows, &row), right = split(at.x, columns, &column);
    for (int c = 0; c < descriptors.size[1]; ++c) {
      const auto of = [&](int v, int u) {
        const int index[] = {0, c, std::min(v, rows - 1), std::min(u, columns - 1)};
        return descriptors.at<float>(index);
      };
      descriptor[c] = (1 - down) * ((1 - right) * of(row, column) + right * of(row, column + 1)) +
                      down * ((1 - right) * of(row + 1, column) + right * of(row + 1, column + 1));
    }
  }

  NetworkPointOptions options_;
  std::filesystem::path path_;
  highwall::FeatureType kind_;
  cv::dnn::Net net_;
};
