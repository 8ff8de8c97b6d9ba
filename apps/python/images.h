#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <cstdint>

#include <opencv2/core/mat.hpp>

namespace highwall::python {

namespace py = pybind11;

using ColourArray = py::array_t<std::uint8_t, py::array::c_style | py::array::forcecast>;
using DepthArray = py::array_t<float, py::array::c_style | py::array::forcecast>;

// Copies: an image that the library keeps must not change under it. bgr: height x width x 3 of
// uint8 in OpenCV's order. depth: height x width, metres, 0 where nothing was measured. Throw
// InvalidArgument for another shape.
cv::Mat ColourImage(const ColourArray& bgr);
cv::Mat DepthImage(const DepthArray& depth);
// A copy of an array of two dimensions, of uint8 or float32, strided as it may be.
cv::Mat MatrixOf(const py::array& array);
// CV_8UC1, CV_8UC3 or CV_32FC1.
py::array ImageArray(const cv::Mat& image);

}  // namespace highwall::python
