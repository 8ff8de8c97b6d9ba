#pragma once

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "support/temporary_directory.h"

// Recordings of OpenNI 2 (.oni) as its file device plays them: a header, and records of 32-bit
// words, little-endian: magic, type, node, size of the fields with this head, size of the payload,
// and 64 bits that only seeking needs. Source: the headers of its driver OniFile, DataRecords.h and
// XnPropNames.h (OpenNI 2.2).
namespace highwall::testing {

struct OniFrame {
  std::uint64_t microseconds = 0;  // > 0
  cv::Mat rgb;                     // CV_8UC3
  cv::Mat depth;                   // CV_16UC1 [mm], of the same size
};

struct OniFile {
  std::vector<OniFrame> frames;
  double horizontal_field_of_view = 1.0, vertical_field_of_view = 0.8;  // [rad]
};

// Bytes of numbers and strings.
class OniBytes {
 public:
  template <class T>
  OniBytes& Add(T value) {
    char bytes[sizeof(T)];
    std::memcpy(bytes, &value, sizeof(T));
    bytes_.append(bytes, sizeof(T));
    return *this;
  }
  OniBytes& Add(std::string_view text) {
    Add(static_cast<std::uint32_t>(text.size() + 1));
    bytes_.append(text).push_back('\0');
    return *this;
  }
  const std::string& text() const { return bytes_; }

 private:
  std::string bytes_;
};

inline std::string OniRecord(std::uint32_t type, std::uint32_t node, const OniBytes& fields = {},
                             std::string_view payload = {}) {
  constexpr std::uint32_t kMagic = 0x0052494E, kHead = 28;
  OniBytes head;
  head.Add(kMagic).Add(type).Add(node);
  head.Add(static_cast<std::uint32_t>(kHead + fields.text().size()));
  head.Add(static_cast<std::uint32_t>(payload.size())).Add(std::uint64_t{0});
  return head.text() + fields.text() + std::string(payload);
}

// A stream without compression: its declaration and its properties. type: 2 for depth, 3 for
// colour.
inline std::string OniNode(std::uint32_t node, std::uint32_t type, const OniFile& file) {
  constexpr std::uint32_t kAdded = 0x0D, kGeneral = 0x06, kReady = 0x09;
  constexpr std::uint32_t kUncompressed = 0x454E4F4E;  // "NONE"
  const cv::Mat& image = file.frames.front().rgb;
  OniBytes added;
  added.Add(std::string_view(type == 2 ? "Depth1" : "Image1")).Add(type).Add(kUncompressed);
  added.Add(static_cast<std::uint32_t>(file.frames.size()));
  added.Add(file.frames.front().microseconds).Add(file.frames.back().microseconds);
  added.Add(std::uint64_t{0});
  OniBytes mode;
  mode.Add(std::string_view("xnMapOutputMode")).Add(std::uint32_t{12});
  mode.Add(static_cast<std::uint32_t>(image.cols)).Add(static_cast<std::uint32_t>(image.rows));
  mode.Add(std::uint32_t{30});
  OniBytes view;
  view.Add(std::string_view("xnFOV")).Add(std::uint32_t{16});
  view.Add(file.horizontal_field_of_view).Add(file.vertical_field_of_view);
  OniBytes cropping;
  cropping.Add(std::string_view("xnCropping")).Add(std::uint32_t{12});
  cropping.Add(std::uint32_t{0}).Add(std::uint64_t{0});
  return OniRecord(kAdded, node, added) + OniRecord(kGeneral, node, mode) +
         OniRecord(kGeneral, node, view) + OniRecord(kGeneral, node, cropping) +
         OniRecord(kReady, node);
}

inline std::string OniImage(std::uint32_t node, std::uint64_t microseconds, std::size_t number,
                            const cv::Mat& image) {
  const cv::Mat whole = image.isContinuous() ? image : image.clone();
  OniBytes fields;
  fields.Add(microseconds).Add(static_cast<std::uint32_t>(number));
  return OniRecord(0x0A, node, fields,
                   {reinterpret_cast<const char*>(whole.data), whole.total() * whole.elemSize()});
}

// file: with at least one frame.
inline void WriteOni(const std::filesystem::path& path, const OniFile& file) {
  constexpr std::uint32_t kDepth = 0, kColour = 1, kBegin = 0x08, kEnd = 0x0B;
  std::string text = "NI10";
  text += OniBytes()
              .Add(std::uint8_t{1})
              .Add(std::uint8_t{0})
              .Add(std::uint16_t{1})
              .Add(std::uint32_t{0})
              .Add(file.frames.back().microseconds)
              .Add(kColour)
              .text();
  text += OniNode(kDepth, 2, file) + OniNode(kColour, 3, file);
  for (const std::uint32_t node : {kDepth, kColour}) {
    text += OniRecord(kBegin, node,
                      OniBytes()
                          .Add(static_cast<std::uint32_t>(file.frames.size()))
                          .Add(file.frames.back().microseconds));
  }
  for (std::size_t i = 0; i < file.frames.size(); ++i) {
    const OniFrame& frame = file.frames[i];
    text += OniImage(kDepth, frame.microseconds, i + 1, frame.depth);
    text += OniImage(kColour, frame.microseconds, i + 1, frame.rgb);
  }
  WriteText(path, text + OniRecord(kEnd, kDepth));
}

}  // namespace highwall::testing
