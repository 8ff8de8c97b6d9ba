#pragma once

#include <pybind11/pybind11.h>

#include <memory>

#include <highwall/frontend/features/point_extractor.h>

#include "exclusive.h"

namespace highwall::python {

namespace py = pybind11;

// Extractor written in Python: a class derived from PointExtractor with
//   extract(self, gray) -> (keypoints, descriptors)
// Acquires the GIL while it extracts.
class PythonPoints : public PointExtractor {
 public:
  // Throws InvalidArgument for an invalid kind.
  explicit PythonPoints(FeatureType kind);

  const FeatureType& kind() const override { return kind_; }
  ExtractedPoints Extract(const cv::Mat& gray) override;

 private:
  const FeatureType kind_;
};

// Returns the extractor of a Python object, for use by the object behind the gate, and keeps the
// Python object alive; null for None.
std::shared_ptr<PointExtractor> SharePoints(const py::object& points,
                                            const std::shared_ptr<CallGate>& gate);

}  // namespace highwall::python
