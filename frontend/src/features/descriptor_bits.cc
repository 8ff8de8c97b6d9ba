#include "features/descriptor_bits.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <numeric>
#include <random>
#include <utility>

#include <Eigen/QR>

namespace highwall {
namespace {

constexpr int kBits = 256, kBytes = kBits / 8;
using RowMajor = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// Draws from the standard normal distribution, identically with every standard library (Box, Muller
// 1958).
double DrawNormal(std::mt19937& rng) {
  const auto uniform = [&] { return (static_cast<double>(rng()) + 0.5) * 0x1p-32; };
  const double radius = std::sqrt(-2.0 * std::log(uniform()));
  return radius * std::cos(2.0 * std::numbers::pi * uniform());
}

// Returns columns x 256 unit vectors; each group of `columns` consecutive ones is orthogonal.
Eigen::MatrixXf DrawNormals(int columns) {
  std::mt19937 rng(1);
  Eigen::MatrixXf normals(columns, kBits);
  for (int first = 0; first < kBits; first += columns) {
    const int count = std::min(columns, kBits - first);
    const Eigen::MatrixXd drawn =
        Eigen::MatrixXd::NullaryExpr(columns, count, [&] { return DrawNormal(rng); });
    const Eigen::MatrixXd orthogonal =
        drawn.householderQr().householderQ() * Eigen::MatrixXd::Identity(columns, count);
    normals.middleCols(first, count) = orthogonal.cast<float>();
  }
  return normals;
}

// Returns which of `bits` bits make each of the 256: random permutations of all, one after the
// other.
std::vector<int> DrawBits(int bits) {
  std::mt19937 rng(1);
  std::vector<int> order(static_cast<std::size_t>(bits)), drawn;
  std::iota(order.begin(), order.end(), 0);
  while (drawn.size() < kBits) {
    for (std::size_t i = order.size() - 1; i > 0; --i) std::swap(order[i], order[rng() % (i + 1)]);
    drawn.insert(drawn.end(), order.begin(), order.end());
  }
  drawn.resize(kBits);
  return drawn;
}

void SetBit(std::uint8_t* descriptor, int bit, bool value) {
  descriptor[bit / 8] =
      static_cast<std::uint8_t>(descriptor[bit / 8] | ((value ? 1 : 0) << (bit % 8)));
}

}  // namespace

DescriptorBits::DescriptorBits(DescriptorType type, int columns) {
  if (type == DescriptorType::kFloat) {
    normals_ = DrawNormals(columns);
    // Equivalent to subtracting the mean of every descriptor.
    normals_.rowwise() -= normals_.colwise().mean().eval();
  } else if (columns != kBytes) {
    drawn_ = DrawBits(8 * columns);
  }
}

cv::Mat DescriptorBits::Of(const cv::Mat& descriptors) const {
  if (descriptors.empty()) return {};
  if (normals_.size() > 0) return OfFloats(descriptors);
  // A deep copy, since an extractor may write the next image's descriptors into the same memory.
  return drawn_.empty() ? descriptors.clone() : OfBits(descriptors);
}

cv::Mat DescriptorBits::OfFloats(const cv::Mat& descriptors) const {
  const Eigen::Map<const RowMajor, 0, Eigen::OuterStride<>> rows(
      descriptors.ptr<float>(), descriptors.rows, descriptors.cols,
      Eigen::OuterStride<>(static_cast<Eigen::Index>(descriptors.step1())));
  const RowMajor sides = rows * normals_;
  cv::Mat bits = cv::Mat::zeros(descriptors.rows, kBytes, CV_8U);
  for (int i = 0; i < bits.rows; ++i) {
    for (int bit = 0; bit < kBits; ++bit) SetBit(bits.ptr(i), bit, sides(i, bit) > 0.0F);
  }
  return bits;
}

cv::Mat DescriptorBits::OfBits(const cv::Mat& descriptors) const {
  cv::Mat bits = cv::Mat::zeros(descriptors.rows, kBytes, CV_8U);
  for (int i = 0; i < bits.rows; ++i) {
    const std::uint8_t* const from = descriptors.ptr(i);
    for (int bit = 0; bit < kBits; ++bit) {
      const int source = drawn_[static_cast<std::size_t>(bit)];
      SetBit(bits.ptr(i), bit, ((from[source / 8] >> (source % 8)) & 1) != 0);
    }
  }
  return bits;
}

}  // namespace highwall
