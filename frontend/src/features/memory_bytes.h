#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include <opencv2/core/mat.hpp>

#include <highwall/frontend/features/frame.h>

namespace highwall {

// Bytes of the pixels of an image or of the values of a matrix; 0 if it is empty.
inline std::size_t BytesOf(const cv::Mat& mat) {
  return mat.empty() ? 0 : mat.total() * mat.elemSize();
}
template <class T>
std::size_t BytesOf(const std::vector<T>& values) {
  return values.capacity() * sizeof(T);
}
std::size_t BytesOf(const FrameFeatures& features);

// Returns the features without the images, for frames that are kept for later.
std::shared_ptr<const FrameFeatures> WithoutImages(const FrameFeatures& features);

}  // namespace highwall
