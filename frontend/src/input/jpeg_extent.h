#pragma once

#include <cstdint>
#include <span>

namespace highwall {

// Completeness of a JPEG file.
enum class JpegExtent {
  kWhole,      // up to the end marker; data added by cameras behind it is ignored
  kNoEnd,      // the complete picture, but without the end marker
  kTruncated,  // less than the picture
};

// Parses the segments and counts the blocks of the picture without decoding them, since a decoder
// reports no error for a picture without its lower part. A progressive picture without its end
// marker counts as complete once its last scan is a refinement scan. bytes: begin with FF D8.
// Source: ITU-T T.81, Annexes B (segments), F (sequential coding) and G (progressive coding).
JpegExtent ExtentOfJpeg(std::span<const std::uint8_t> bytes);

}  // namespace highwall
