#include "run/frame_source.h"

#include <algorithm>

#include <highwall/internal/stage_timer.h>

namespace highwall::apps {

FrameSource::FrameSource(const Dataset& dataset, const FrameReaderOptions& options, bool live)
    : profile_(options.profile) {
  if (live) {
    live_.emplace(dataset, options);
  } else {
    reader_.emplace(dataset, options);
  }
}

std::optional<RgbdImage> FrameSource::Next() {
  const StageTimer timer(profile_, "next image");
  return live_ ? live_->Next() : reader_->Next();
}

std::size_t FrameSource::left() const {
  return count() - std::min(position(), count());
}

void FrameSource::Measure(Stamp stamp) {
  if (live_) delays_.push_back(live_->MillisecondsSince(stamp));
}

}  // namespace highwall::apps
