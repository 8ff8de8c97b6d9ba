#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>

#include <highwall/core/trajectory.h>
#include <highwall/frontend/input/dataset.h>

namespace highwall::bench {

// Dataset with a temporarily covered lens: black images without depth.
class CoveredLens final : public Dataset {
 public:
  // dataset: must outlive this. [begin, end]: stamps.
  CoveredLens(const Dataset& dataset, Stamp begin, Stamp end)
      : dataset_(dataset), begin_(begin), end_(end) {}

  std::size_t size() const override { return dataset_.size(); }
  Stamp stamp(std::size_t index) const override { return dataset_.stamp(index); }
  const Trajectory* groundtruth() const override { return dataset_.groundtruth(); }
  std::optional<std::filesystem::path> imu_file() const override { return dataset_.imu_file(); }
  ImuRecording ReadImu(const VideoSpan& video) const override { return dataset_.ReadImu(video); }

 private:
  RgbdImage DoLoad(std::size_t index) const override;

  const Dataset& dataset_;
  Stamp begin_, end_;
};

}  // namespace highwall::bench
