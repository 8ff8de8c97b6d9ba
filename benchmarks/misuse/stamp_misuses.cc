#include <cmath>
#include <cstddef>
#include <functional>
#include <utility>
#include <vector>

#include <fmt/core.h>

#include <highwall/core/stamp.h>

#include "misuses.h"

namespace highwall::bench {
namespace {

using Frames = std::vector<StatedFrame>;

Misuse Stamps(std::string fault, std::string strength, const std::function<void(Frames*)>& change) {
  return {std::move(fault),
          std::move(strength),
          {SensorFault::kStamps},
          false,
          [change](StatedRecording* stated) { change(&stated->frames); }};
}

Misuse FrameNumbers(Stamp first) {
  return Stamps("frame numbers", fmt::format("from {}", first), [first](Frames* frames) {
    for (std::size_t i = 0; i < frames->size(); ++i) {
      (*frames)[i].stamp = (first + static_cast<Stamp>(i)) * 1'000'000'000;
    }
  });
}

// Stamps count a smaller unit, as if it was a second; from zero, as a sensor since its start.
Misuse Unit(const char* unit, Stamp per_second) {
  return Stamps("unit of stamps", unit, [per_second](Frames* frames) {
    const Stamp first = frames->front().stamp;
    for (StatedFrame& frame : *frames) frame.stamp = (frame.stamp - first) * per_second;
  });
}

Misuse EqualStamps(std::size_t every) {
  return Stamps("equal stamps", fmt::format("one in {}", every), [every](Frames* frames) {
    for (std::size_t i = every - 1; i < frames->size(); i += every) {
      (*frames)[i].stamp = (*frames)[i - 1].stamp;
    }
  });
}

Misuse BackwardStamps() {
  return Stamps("decreasing stamps", "all", [](Frames* frames) {
    for (std::size_t i = 0, j = frames->size() - 1; i < j; ++i, --j) {
      std::swap((*frames)[i].stamp, (*frames)[j].stamp);
    }
  });
}

Misuse ExchangedStamps(std::size_t every) {
  return Stamps("decreasing stamps", fmt::format("one in {}", every), [every](Frames* frames) {
    for (std::size_t i = every - 1; i < frames->size(); i += every) {
      std::swap((*frames)[i].stamp, (*frames)[i - 1].stamp);
    }
  });
}

// Images arrive several at a time and are stamped then, a millisecond apart.
Misuse Bursts(std::size_t images) {
  return Stamps("stamps of arrival", fmt::format("{} at a time", images), [images](Frames* frames) {
    for (std::size_t i = 0; i + images <= frames->size(); i += images) {
      const Stamp arrival = (*frames)[i + images - 1].stamp;
      for (std::size_t j = 0; j < images; ++j) {
        (*frames)[i + j].stamp = arrival - static_cast<Stamp>(images - 1 - j) * 1'000'000;
      }
    }
  });
}

// Depth is paired with a later image, as its own stamp says.
Misuse PairedLate(std::size_t lag) {
  return Stamps("pairs apart",
                lag == 1 ? std::string("by a frame") : fmt::format("by {} frames", lag),
                [lag](Frames* frames) {
                  const Frames right = *frames;
                  for (std::size_t i = lag; i < frames->size(); ++i) {
                    (*frames)[i].depth = right[i - lag].colour;
                    (*frames)[i].depth_delay = right[i - lag].stamp - right[i].stamp;
                  }
                });
}

}  // namespace

std::vector<Misuse> StampMisuses() {
  return {FrameNumbers(0),
          FrameNumbers(1),
          Unit("milliseconds", 1'000),
          Unit("microseconds", 1'000'000),
          EqualStamps(2),
          EqualStamps(10),
          BackwardStamps(),
          ExchangedStamps(10),
          Bursts(3),
          Bursts(6),
          PairedLate(3),
          PairedLate(1)};
}

}  // namespace highwall::bench
