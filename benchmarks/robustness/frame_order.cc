#include "frame_order.h"

#include <algorithm>
#include <utility>

#include <highwall/core/error.h>

namespace highwall::bench {
namespace {

using simulate::CounterRandom;
using Frames = std::vector<AbusedFrame>;

// Assigns the images of `other` to `frame`; the stamp stays.
void ShowImagesOf(const AbusedFrame& other, AbusedFrame* frame) {
  frame->images = other.images;
  frame->colour = other.colour;
  frame->depth = other.depth;
}

}  // namespace

OrderChange EveryNth(std::size_t n) {
  HIGHWALL_REQUIRE(n >= 1, "n must be at least 1");
  return [n](const Frames& frames, const CounterRandom&) {
    Frames kept;
    for (std::size_t i = 0; i < frames.size(); i += n) kept.push_back(frames[i]);
    return kept;
  };
}

OrderChange Gaps(double seconds) {
  constexpr Stamp kShown = 1'500'000'000;  // [ns]
  const Stamp period = kShown + FromSeconds(seconds);
  return [period](Frames frames, const CounterRandom&) {
    const Stamp begin = frames.front().stamp;
    std::erase_if(
        frames, [&](const AbusedFrame& frame) { return (frame.stamp - begin) % period >= kShown; });
    return frames;
  };
}

OrderChange DepthLags(std::size_t lag) {
  return [lag](Frames frames, const CounterRandom&) {
    for (std::size_t i = frames.size(); i-- > 0;)
      frames[i].depth = frames[i - std::min(i, lag)].depth;
    return frames;
  };
}

OrderChange SwappedFrames(double every) {
  return [every](Frames frames, const CounterRandom& random) {
    for (std::size_t i = 0; i + 1 < frames.size(); ++i) {
      if (random.Uniform(i) * every >= 1.0) continue;
      std::swap(frames[i], frames[i + 1]);
      std::swap(frames[i].stamp, frames[i + 1].stamp);
      ++i;  // a frame is swapped at most once
    }
    return frames;
  };
}

OrderChange DoubledFrames(double every) {
  return [every](Frames frames, const CounterRandom& random) {
    for (std::size_t i = 1; i < frames.size(); ++i) {
      if (random.Uniform(i) * every < 1.0) ShowImagesOf(frames[i - 1], &frames[i]);
    }
    return frames;
  };
}

OrderChange CutIn(std::vector<AbusedFrame> elsewhere) {
  HIGHWALL_REQUIRE(elsewhere.size() >= 2, "the inserted sequence must have two frames or more");
  return [elsewhere = std::move(elsewhere)](const Frames& frames, const CounterRandom&) {
    const auto middle = frames.begin() + std::ssize(frames) / 2;
    Frames sequence(frames.begin(), middle);
    const Stamp begin = middle->stamp;
    const Stamp duration = elsewhere.back().stamp - elsewhere.front().stamp;
    const Stamp interval = duration / (std::ssize(elsewhere) - 1);
    for (AbusedFrame frame : elsewhere) {
      frame.stamp += begin - elsewhere.front().stamp;
      sequence.push_back(frame);
    }
    for (auto frame = middle; frame != frames.end(); ++frame) {
      sequence.push_back(*frame);
      sequence.back().stamp += duration + interval;
    }
    return sequence;
  };
}

}  // namespace highwall::bench
