#include "point_extractor.h"

#include <pybind11/numpy.h>

#include <cmath>
#include <memory>
#include <string>
#include <utility>

#include <highwall/core/error.h>

#include "bindings.h"
#include "images.h"
#include "interpreter.h"

namespace highwall::python {
namespace {

using Keypoints = py::array_t<double, py::array::c_style | py::array::forcecast>;

constexpr py::ssize_t kNumbers = 5;  // x y octave angle response

std::vector<cv::KeyPoint> ReadKeypoints(const py::object& object, const std::string& name) {
  const auto array = object.cast<Keypoints>();
  if (array.size() == 0) return {};
  HIGHWALL_REQUIRE(
      array.ndim() == 2 && array.shape(1) == kNumbers,
      "points by " + name + ": keypoints are an array of N x 5: x, y, octave, angle, response");
  const auto rows = array.unchecked<2>();
  std::vector<cv::KeyPoint> keypoints;
  for (py::ssize_t i = 0; i < rows.shape(0); ++i) {
    HIGHWALL_REQUIRE(std::abs(rows(i, 2)) <= 1e6,
                     "points by " + name + ": keypoint " + std::to_string(i) + " has no octave");
    keypoints.emplace_back(static_cast<float>(rows(i, 0)), static_cast<float>(rows(i, 1)), 1.0F,
                           static_cast<float>(rows(i, 3)), static_cast<float>(rows(i, 4)),
                           static_cast<int>(std::lround(rows(i, 2))));
  }
  return keypoints;
}

cv::Mat ReadDescriptors(const py::object& object, const std::string& name) {
  const auto array = py::array::ensure(object);
  if (array && array.size() == 0) return {};
  HIGHWALL_REQUIRE(array && array.ndim() == 2 &&
                       (py::isinstance<py::array_t<std::uint8_t>>(array) ||
                        py::isinstance<py::array_t<float>>(array)),
                   "points by " + name +
                       ": descriptors are an array of N x columns, of uint8 or "
                       "float32");
  return MatrixOf(array);
}

// An extractor written in Python, used by the object behind a gate.
class CalledPoints final : public PointExtractor {
 public:
  CalledPoints(const py::object& points, std::shared_ptr<CallGate> gate)
      : gate_(std::move(gate)),
        owner_(gate_->Keep(points)),
        points_(*points.cast<PythonPoints*>()),
        kind_(points_.kind()) {}

  const FeatureType& kind() const override { return kind_; }
  ExtractedPoints Extract(const cv::Mat& gray) override {
    const InterpreterLock lock;
    if (!lock.IsTaken()) return {};
    const py::object owner = owner_->Get();
    if (!owner) return {};
    const CallGate::Work work(*gate_);
    return points_.Extract(gray);
  }

 private:
  const std::shared_ptr<CallGate> gate_;
  const std::shared_ptr<Reference> owner_;
  PythonPoints& points_;
  const FeatureType kind_;
};

}  // namespace

PythonPoints::PythonPoints(FeatureType kind) : kind_(std::move(kind)) {
  kind_.Validate();
}

ExtractedPoints PythonPoints::Extract(const cv::Mat& gray) {
  const py::gil_scoped_acquire lock;
  const py::function extract = py::get_override(this, "extract");
  HIGHWALL_REQUIRE(extract, "the class of a point extractor needs a function extract(self, gray)");
  const py::object found = extract(ImageArray(gray));
  HIGHWALL_REQUIRE(py::isinstance<py::tuple>(found) && py::len(found) == 2,
                   "points by " + kind_.name + ": extract() returns (keypoints, descriptors)");
  const auto pair = found.cast<py::tuple>();
  return {ReadKeypoints(pair[0], kind_.name), ReadDescriptors(pair[1], kind_.name)};
}

std::shared_ptr<PointExtractor> SharePoints(const py::object& points,
                                            const std::shared_ptr<CallGate>& gate) {
  if (points.is_none()) return nullptr;
  HIGHWALL_REQUIRE(py::isinstance<PythonPoints>(points), "points: a PointExtractor, or None");
  return std::make_shared<CalledPoints>(points, gate);
}

void BindPointExtractor(py::module_& module) {
  py::enum_<DescriptorType>(module, "DescriptorType")
      .value("BINARY", DescriptorType::kBinary, "uint8, eight bits a column.")
      .value("FLOAT", DescriptorType::kFloat, "float32.");
  py::class_<PythonPoints, std::shared_ptr<PythonPoints>>(
      module, "PointExtractor",
      "Points of your own for SlamSystem: derive from it, call PointExtractor.__init__(self, name, "
      "columns, ...), and define extract(self, gray) -> (keypoints, descriptors). gray: height x "
      "width of uint8, as the camera gave it. keypoints: N x 5: x, y [px], octave, angle [deg, "
      "negative: none], response. descriptors: N x columns of uint8 or float32.")
      .def(py::init([](std::string name, int columns, DescriptorType descriptor, int levels,
                       double scale_factor, float low_contrast_response) {
             return std::make_shared<PythonPoints>(
                 FeatureType{.name = std::move(name),
                             .descriptor = descriptor,
                             .columns = columns,
                             .pyramid = {.levels = levels, .scale_factor = scale_factor},
                             .low_contrast_response = low_contrast_response});
           }),
           py::arg("name"), py::arg("columns"), py::kw_only(),
           py::arg("descriptor") = DescriptorType::kBinary,
           py::arg("levels") = PyramidOptions{}.levels,
           py::arg("scale_factor") = PyramidOptions{}.scale_factor,
           py::arg("low_contrast_response") = FeatureType{}.low_contrast_response,
           "name: of the kind of descriptor, kept in map files. levels, scale_factor: by which a "
           "point is coarser from octave to octave. low_contrast_response: with less none begins a "
           "map.")
      .def_property_readonly("name", [](const PythonPoints& points) { return points.kind().name; });
}

}  // namespace highwall::python
