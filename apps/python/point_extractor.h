#pragma once

#include <pybind11/pybind11.h>

#include <memory>

#include <highwall/frontend/features/point_extractor.h>

#include "exclusive.h"

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

// The extractor of a Python object, for the object behind the gate. It keeps the Python object
// alive; null where that is None.
std::shared_ptr<PointExtractor> SharePoints(const py::object& points,
                                            const std::shared_ptr<CallGate>& gate);

}  // namespace highwall::python
