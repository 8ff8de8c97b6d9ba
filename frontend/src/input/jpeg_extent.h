#pragma once

#include <cstdint>
#include <span>

namespace highwall {

// How much of a JPEG a file holds.
enum class JpegExtent {
  kWhole,      // up to the end marker; what cameras add behind it does not matter
  kNoEnd,      // all of the picture, but without the end marker
  kTruncated,  // less than the picture
};

// Walks the segments and counts the blocks of the picture without decoding them, for a picture
// without its lower part is decoded without an error. A progressive picture without its end marker
// is taken for whole once its last scans refine what is there. bytes: begin with FF D8.
// Source: ITU-T T.81, Annexes B (segments), F (sequential coding) and G (progressive coding).
JpegExtent ExtentOfJpeg(std::span<const std::uint8_t> bytes);

}  // namespace highwall
