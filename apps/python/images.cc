#include "images.h"

#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include <highwall/core/error.h>

namespace highwall::python {
namespace {

template <class T>
using Contiguous = py::array_t<T, py::array::c_style | py::array::forcecast>;

cv::Mat CopyOf(const py::array& contiguous, int type) {
  cv::Mat image(static_cast<int>(contiguous.shape(0)), static_cast<int>(contiguous.shape(1)), type);
  std::memcpy(image.data, contiguous.data(), static_cast<std::size_t>(contiguous.nbytes()));
  return image;
}

py::array ArrayOf(const py::object& object) {
  py::array array = py::array::ensure(object);
  if (!array) throw py::error_already_set();
  return array;
}

// remedy: advice for another type.
[[noreturn]] void RefuseType(const py::array& array, const std::string& what,
                             const std::string& remedy) {
  throw py::type_error(what + ", not of " + py::str(array.dtype()).cast<std::string>() + ": " +
                       remedy);
}

}  // namespace

py::array_t<std::uint8_t> BytesOf(const py::object& object, const char* what) {
  const py::array array = ArrayOf(object);
  if (!py::isinstance<py::array_t<std::uint8_t>>(array)) {
    RefuseType(array, std::string(what) + " is an array of uint8",
               array.dtype().kind() == 'f' ? "(255 * array).astype(numpy.uint8) where 1.0 is white"
                                           : "scale it to 0..255, then .astype(numpy.uint8)");
  }
  return Contiguous<std::uint8_t>(array);
}

cv::Mat ColourImage(const py::object& bgr) {
  const py::array_t<std::uint8_t> bytes = BytesOf(bgr, "a colour image");
  HIGHWALL_REQUIRE(bytes.ndim() == 3 && bytes.shape(2) == 3,
                   "a colour image is an array of height x width x 3");
  return CopyOf(bytes, CV_8UC3);
}

cv::Mat DepthImage(const py::object& depth) {
  const py::array array = ArrayOf(depth);
  const py::dtype type = array.dtype();
  if (type.kind() != 'f' && !(type.kind() == 'u' && type.itemsize() == 2)) {
    RefuseType(array, "a depth image is an array of floats or uint16, in metres",
               "(array / depth_factor).astype(numpy.float32), with the stored value of one metre");
  }
  HIGHWALL_REQUIRE(array.ndim() == 2, "a depth image is an array of height x width, in metres");
  return CopyOf(Contiguous<float>(array), CV_32FC1);
}

cv::Mat MatrixOf(const py::array& array) {
  if (py::isinstance<py::array_t<float>>(array)) return CopyOf(Contiguous<float>(array), CV_32FC1);
  return CopyOf(BytesOf(array, "a matrix"), CV_8UC1);
}

py::array ImageArray(const cv::Mat& image) {
  std::vector<py::ssize_t> shape = {image.rows, image.cols};
  if (image.channels() > 1) shape.push_back(image.channels());
  const py::dtype type =
      image.depth() == CV_32F ? py::dtype::of<float>() : py::dtype::of<std::uint8_t>();
  py::array array(type, shape);
  const cv::Mat whole = image.isContinuous() ? image : image.clone();
  std::memcpy(array.mutable_data(), whole.data, whole.total() * whole.elemSize());
  return array;
}

}  // namespace highwall::python
