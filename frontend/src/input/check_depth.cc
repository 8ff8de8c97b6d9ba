#include <algorithm>
#include <cstddef>
#include <optional>
#include <vector>

#include <opencv2/core.hpp>

#include <highwall/core/stamp.h>
#include <highwall/frontend/input/depth_check.h>
#include <highwall/frontend/input/depth_stamp.h>
#include <highwall/frontend/input/repeated_image.h>

namespace highwall {
namespace {

constexpr std::size_t kImages = 8;     // that are tested
constexpr std::size_t kMostParts = 4;  // images as many times, where they are unclear
// [s] between more images: nearer ones are of one view, and their errors are the same.
constexpr double kApart = 0.12;
// [s] that show a delay: in less, one motion over one view fits a wrong moment as well.
constexpr double kDelaySeconds = 2.0;
constexpr std::size_t kImagesAround = 4;  // colour images before and after, for a delay

bool HasUnregistered(const std::vector<SensorFinding>& findings) {
  return std::ranges::find(findings, SensorFault::kDepthUnregistered, &SensorFinding::fault) !=
         findings.end();
}

// Frames of a recording whose images are stored as the sensor says.
class CheckedFrames {
 public:
  CheckedFrames(const Dataset& dataset, const RgbdSensor& sensor, std::size_t begin,
                std::size_t end)
      : dataset_(dataset), sensor_(sensor), begin_(begin), size_(end - begin) {}

  std::size_t size() const { return size_; }
  double seconds() const {
    return ToSeconds(dataset_.stamp(begin_ + size_ - 1) - dataset_.stamp(begin_));
  }
  // Adds a frame of the size of the first.
  void Add(std::size_t index, DepthCheck* check) {
    if (const auto image = Load(index)) check->Add(Stored(*image), image->bgr);
  }
  // Adds every other one of eight frames, from this one on, with those around them.
  void AddAround(std::size_t first, DepthCheck* check) {
    if (size_ < kImages + 2) return;
    const std::size_t around = std::min(kImagesAround, (size_ - kImages) / 2);
    for (std::size_t i = first; i < kImages; i += 2) {
      AddAround(around + (2 * i + 1) * (size_ - 2 * around) / (2 * kImages), around, check);
    }
  }

 private:
  cv::Mat Stored(const RgbdImage& image) const { return StoredDepth(image.depth, sensor_); }
  std::optional<RgbdImage> Load(std::size_t index) {
    std::optional<RgbdImage> image = dataset_.Load(begin_ + index);
    if (!image || (!image_size_.empty() && image->depth.size() != image_size_)) return {};
    image_size_ = image->depth.size();
    return image;
  }
  void AddAround(std::size_t index, std::size_t around, DepthCheck* check) {
    std::vector<cv::Mat> bgr;
    cv::Mat raw;
    RepeatedImage repeated;
    double stated = sensor_.timing.depth_delay;
    for (std::size_t i = index - around; i <= index + around; ++i) {
      const std::optional<RgbdImage> image = Load(i);
      // Where colour repeats, its moments are not those of its stamps.
      if (!image || repeated.Update(image->bgr)) return;
      bgr.push_back(image->bgr);
      if (i != index) continue;
      raw = Stored(*image);
      stated += DepthDelay(*image);
    }
    const double span = ToSeconds(dataset_.stamp(begin_ + index + around) -
                                  dataset_.stamp(begin_ + index - around));
    if (span > 0.0) check->AddAround(raw, bgr, span / static_cast<double>(2 * around), stated);
  }

  const Dataset& dataset_;
  const RgbdSensor& sensor_;
  std::size_t begin_, size_;
  cv::Size image_size_{};
};

}  // namespace

std::vector<SensorFinding> CheckDepth(const Dataset& dataset, const RgbdSensor& sensor,
                                      std::size_t begin, std::size_t end) {
  end = std::min(end, dataset.size());
  if (begin >= end) return {};
  DepthCheck check(sensor);
  CheckedFrames frames(dataset, sensor, begin, end);
  const std::size_t count = std::min(kImages, frames.size());
  for (std::size_t i = 0; i < count; ++i) {
    frames.Add((2 * i + 1) * frames.size() / (2 * count), &check);
  }
  std::vector<SensorFinding> findings = check.Findings();
  // Edges of a single view fit elsewhere by chance.
  const bool is_one_view = frames.seconds() < kApart * static_cast<double>(kImages);
  std::size_t around = 0;
  // A finding of edges must hold against any usual delay of the images around all eight.
  const auto add_around = [&](std::size_t halves) {
    if (around >= halves) return;
    for (; around < halves; ++around) frames.AddAround(around, &check);
    findings = check.Findings();
  };
  if (findings.empty() && check.IsUnclear() && frames.seconds() >= kDelaySeconds) {
    add_around(1);
    if (check.MayBeDelayed()) add_around(2);
  }
  if (HasUnregistered(findings)) add_around(2);
  // Between them, and then between those and after the last.
  for (std::size_t parts = 2; parts <= kMostParts; parts *= 2) {
    if (!findings.empty() || frames.size() < 2 * parts * kImages || !check.MayMoreImagesShow())
      break;
    if (frames.seconds() < kApart * static_cast<double>(parts * kImages)) break;
    for (std::size_t i = 1; i < parts * kImages / 2; ++i) {
      const std::size_t half = 2 * i + (parts == 2 ? 0 : 1);
      frames.Add(half * frames.size() / (parts * kImages), &check);
    }
    findings = check.Findings();
    if (HasUnregistered(findings)) add_around(2);
  }
  const auto drop = [&findings](SensorFault fault) {
    std::erase_if(findings,
                  [fault](const SensorFinding& finding) { return finding.fault == fault; });
  };
  if (dataset.is_registered() || is_one_view) drop(SensorFault::kDepthUnregistered);
  if (frames.seconds() < kDelaySeconds) drop(SensorFault::kDepthInconsistent);
  return findings;
}

}  // namespace highwall
