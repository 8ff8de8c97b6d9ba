#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <cstdint>

#include <opencv2/core/mat.hpp>

namespace highwall::python {

namespace py = pybind11;

// Return copies, because an image that the library keeps must not change. bgr: height x width x 3,
// uint8, in OpenCV's order. depth: height x width, float or uint16, metres, 0 for missing
// measurements. Throw py::type_error for another type, since a conversion would change the image,
// and InvalidArgument for another shape.
cv::Mat ColourImage(const py::object& bgr);
cv::Mat DepthImage(const py::object& depth);
// Copies a two-dimensional array of uint8 or float32 with any strides. Throws py::type_error for
// another type.
cv::Mat MatrixOf(const py::array& array);
// Accepts CV_8UC1, CV_8UC3 or CV_32FC1.
py::array ImageArray(const cv::Mat& image);

// Returns the array of an object of type uint8; otherwise throws py::type_error. what: name of the
// array in the message.
py::array_t<std::uint8_t> BytesOf(const py::object& object, const char* what);

}  // namespace highwall::python
