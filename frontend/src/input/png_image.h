#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include <opencv2/core/mat.hpp>

namespace highwall {

enum class PngCondition { kWhole, kTruncated, kDamaged };

// True if the bytes begin with the signature of PNG.
bool IsPng(std::span<const std::uint8_t> bytes);

// Checks lengths and checksums of the chunks up to IEND. bytes: begin with the signature.
// Source: PNG Specification (W3C, 2nd edition), Section 5.
PngCondition ConditionOfPng(std::span<const std::uint8_t> bytes);

// Decodes what depth cameras and colour cameras write: grey of 8 or 16 bits and RGB of 8 bits, not
// interlaced, as CV_8UC1, CV_16UC1 and CV_8UC3 in the order BGR. Twice as fast as libpng, by
// libdeflate. bytes: a whole file by ConditionOfPng. Returns nullopt for other kinds, and for image
// data that cannot be decompressed.
// Source: PNG Specification (W3C, 2nd edition), Sections 9 (filters) and 11.2 (critical chunks).
std::optional<cv::Mat> DecodePng(std::span<const std::uint8_t> bytes);

}  // namespace highwall
