#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <cstdint>

#include <opencv2/core/mat.hpp>

namespace highwall::python {

namespace py = pybind11;

// Copies: an image that the library keeps must not change under it. bgr: height x width x 3 of
// uint8 in OpenCV's order. depth: height x width of floats or uint16, metres, 0 where nothing was
// measured. Throw py::type_error for another type, which a conversion would make another image of,
// and InvalidArgument for another shape.
cv::Mat ColourImage(const py::object& bgr);
cv::Mat DepthImage(const py::object& depth);
// A copy of an array of two dimensions, of uint8 or float32, strided as it may be. Throws
// py::type_error for another type.
cv::Mat MatrixOf(const py::array& array);
// CV_8UC1, CV_8UC3 or CV_32FC1.
py::array ImageArray(const cv::Mat& image);

// The array of an object, where its type is uint8: throws py::type_error else. what: the array's
// name in the message.
py::array_t<std::uint8_t> BytesOf(const py::object& object, const char* what);

}  // namespace highwall::python
