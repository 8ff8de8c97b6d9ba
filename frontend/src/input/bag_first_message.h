#pragma once

#include <cstdint>

#include <highwall/core/error.h>

#include "input/bag_file.h"

namespace highwall {

// Returns read(message) for the first message of a topic for which it throws no IoError. Throws
// that of the last one after thirty, and IoError for a topic without any.
template <class Read>
auto ReadFirstMessage(const BagFile& bag, std::uint32_t topic, const Read& read) {
  constexpr int kMostTried = 30;
  int tried = 0;
  for (const BagMessage& message : bag.messages()) {
    if (message.topic != topic) continue;
    try {
      return read(message);
    } catch (const IoError&) {
      if (++tried == kMostTried) throw;
    }
  }
  throw IoError(bag.path(), bag.topics()[topic].name + " has no message that can be read");
}

}  // namespace highwall
