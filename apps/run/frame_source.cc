#include "run/frame_source.h"

#include <algorithm>

#include <highwall/core/error.h>
#include <highwall/internal/stage_timer.h>

namespace highwall::apps {

FrameSource::FrameSource(const Dataset& dataset, ImageSource* camera, const SlamRunOptions& options,
                         RunProfile* profile)
    : profile_(profile), camera_(camera) {
  if (camera_ != nullptr) return;
  const FrameReaderOptions range{
      .begin = options.begin, .end = options.end, .prefetch = options.prefetch, .profile = profile};
  if (options.live) {
    live_.emplace(dataset, range, options.live_rate);
  } else {
    reader_.emplace(dataset, range);
  }
}

std::optional<RgbdImage> FrameSource::Next() {
  const StageTimer timer(profile_, "next image");
  if (camera_ == nullptr) return live_ ? live_->Next() : reader_->Next();
  try {
    std::optional<RgbdImage> image = camera_->Next();
    if (image) ++taken_;
    return image;
  } catch (const IoError& error) {
    if (taken_ == 0) throw;
    failure_ = error.what();
    return std::nullopt;
  }
}

std::size_t FrameSource::position() const {
  if (camera_ != nullptr) return taken_ + camera_->dropped();
  return live_ ? live_->position() : reader_->position();
}

std::size_t FrameSource::count() const {
  if (camera_ != nullptr) return position();
  return live_ ? live_->count() : reader_->count();
}

std::size_t FrameSource::dropped() const {
  if (camera_ != nullptr) return camera_->dropped();
  return live_ ? live_->dropped() : 0;
}

std::size_t FrameSource::left() const {
  return count() - std::min(position(), count());
}

std::size_t FrameSource::waiting() const {
  if (camera_ != nullptr) return camera_->waiting();
  return live_ ? live_->waiting() : 0;
}

void FrameSource::Measure(Stamp stamp) {
  if (live_) delays_.push_back(live_->MillisecondsSince(stamp));
  if (camera_ == nullptr) return;
  if (const auto delay = camera_->MillisecondsSinceArrival()) delays_.push_back(*delay);
}

void ImuReplay::FeedUntil(Stamp image, SlamSystem& slam) {
  if (!feed_) return;
  if (camera_ != nullptr) {
    for (const ImuSample& sample : camera_->TakeImu()) slam.AddImu(sample);
    return;
  }
  // The clock offset is not yet known exactly.
  const Stamp until = image + FromSeconds(feed_->calibration.time_offset + 0.1);
  for (; next_ < feed_->samples.size() && feed_->samples[next_].stamp <= until; ++next_) {
    slam.AddImu(feed_->samples[next_]);
  }
}

}  // namespace highwall::apps
