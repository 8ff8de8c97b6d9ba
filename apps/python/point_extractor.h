#pragma once

#include <pybind11/pybind11.h>

#include <memory>

#include <highwall/frontend/features/point_extractor.h>

namespace highwall::python {

namespace py = pybind11;

// An extractor that is written in Python: a class derived from PointExtractor with
//   extract(self, gray) -> (keypoints, descriptors)
// Takes the interpreter's lock while it extracts.
class PythonPoints : public PointExtractor {
 public:
  // Throws InvalidArgument where the kind is none.
  explicit PythonPoints(PointKind kind);

  const PointKind& kind() const override { return kind_; }
  ExtractedPoints Extract(const cv::Mat& gray) override;

 private:
  const PointKind kind_;
};

// The extractor of a Python object, which lives as long as the pointer does; null where it is None.
std::shared_ptr<PointExtractor> SharePoints(const py::object& points);

}  // namespace highwall::python
