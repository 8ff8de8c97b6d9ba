#include "input/foreign_calibration.h"

#include <algorithm>
#include <cctype>
#include <fstream>
#include <iterator>
#include <set>
#include <string>
#include <vector>

#include <highwall/core/error.h>
#include <highwall/internal/number_text.h>
#include <highwall/internal/text_file.h>

#include "input/euroc_sensor.h"
#include "input/kalibr_chain.h"
#include "input/open3d_intrinsic.h"
#include "input/opencv_calibration.h"
#include "input/opencv_storage.h"
#include "input/orbslam_settings.h"

namespace highwall {
namespace {

using Keys = std::set<std::string>;

constexpr const char* kOpencvMatrix = "!!opencv-matrix";

struct ForeignForm {
  std::vector<Keys> marks;  // each has an alternative among the keys of the text
  SensorCalibration (*read)(const ForeignMap& file, const ImageSizeSource& image_size);
  // Of a form that is not read: its name, and how the file provides the required values.
  const char* name = nullptr;
  const char* words = nullptr;
};

// Calls a reader of a form that states the size of the images.
template <SensorCalibration (*kRead)(const ForeignMap&)>
SensorCalibration ReadSized(const ForeignMap& file, const ImageSizeSource& /*image_size*/) {
  return kRead(file);
}

// In the order in which they are asked.
const std::vector<ForeignForm>& ForeignForms() {
  static const std::vector<ForeignForm> kForms = {
      {{{"Camera.fx", "Camera1.fx"}}, ReadOrbSlamSettings},
      {{{"cam0"}, {"intrinsics"}}, ReadSized<ReadKalibrChain>},
      {{{kOpencvMatrix}, {"camera_matrix", "Camera_Matrix", "cameraMatrix"}},
       ReadSized<ReadOpencvCalibration>},
      {{{kOpencvMatrix}},
       nullptr,
       "a file of OpenCV's FileStorage without image_width, image_height and camera_matrix",
       "fx, cx, fy, cy are the numbers 1, 3, 5 and 6 of the camera matrix, and k1, k2, p1, p2, k3 "
       "the distortion coefficients"},
      {{{"camera_matrix", "K", "k"}, {"image_width", "distortion_model", "projection_matrix"}},
       ReadSized<ReadCameraInfoFile>},
      {{{"intrinsic_matrix"}}, ReadSized<ReadOpen3dIntrinsic>},
      {{{"sensor_type"}, {"intrinsics"}}, ReadSized<ReadEurocSensor>},
      {{{"ppx"}, {"ppy"}},
       nullptr,
       "the intrinsics of librealsense",
       "width, height, fx and fy are its own, cx and cy its ppx and ppy, and k1, k2, p1, p2, k3 "
       "its coeffs"},
  };
  return kForms;
}

bool IsOfKey(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '.';
}

// Returns the words before a colon, and the tag of OpenCV's matrices; comments are ignored.
Keys KeysOfYaml(const std::string& text) {
  Keys keys;
  TextReader lines(text);
  for (std::string line; std::getline(lines, line);) {
    line.resize(std::min(line.find('#'), line.size()));
    if (line.find(kOpencvMatrix) != std::string::npos) keys.insert(kOpencvMatrix);
    for (std::size_t colon = line.find(':'); colon != std::string::npos;
         colon = line.find(':', colon + 1)) {
      std::size_t end = colon;
      while (end > 0 && (line[end - 1] == ' ' || line[end - 1] == '"')) --end;
      std::size_t begin = end;
      while (begin > 0 && IsOfKey(line[begin - 1])) --begin;
      if (begin < end) keys.insert(line.substr(begin, end - begin));
    }
  }
  return keys;
}

// Returns the names of the tags.
Keys KeysOfXml(const std::string& text) {
  Keys keys{kOpencvMatrix};
  for (std::size_t tag = text.find('<'); tag != std::string::npos; tag = text.find('<', tag + 1)) {
    std::size_t end = tag + 1;
    while (end < text.size() && IsOfKey(text[end])) ++end;
    if (end > tag + 1) keys.insert(text.substr(tag + 1, end - tag - 1));
  }
  return keys;
}

const ForeignForm* FindForeignForm(const std::string& text) {
  const Keys keys = IsOpencvXml(text) ? KeysOfXml(text) : KeysOfYaml(text);
  if (keys.contains("camera")) return nullptr;
  for (const ForeignForm& form : ForeignForms()) {
    const bool fits = std::ranges::all_of(form.marks, [&](const Keys& mark) {
      return std::ranges::any_of(mark, [&](const std::string& key) { return keys.contains(key); });
    });
    if (fits) return &form;
  }
  return nullptr;
}

}  // namespace

std::optional<SensorCalibration> ReadForeignCalibration(const std::filesystem::path& path,
                                                        const ImageSizeSource& image_size) {
  if (!std::filesystem::is_regular_file(path)) return std::nullopt;
  const std::string text = ReadTextFile(path);
  const ForeignForm* const form = FindForeignForm(text);
  if (form == nullptr) return std::nullopt;
  if (form->read != nullptr) return form->read(ParseOpencvStorage(path, text), image_size);
  throw IoError(path, "is " + std::string(form->name) +
                          ", which is not read; write 'camera: {width: 640, height: 480, fx: 525, "
                          "fy: 525, cx: 319.5, cy: 239.5}' (with k1, k2, p1, p2, k3 of a lens) and "
                          "'depth_factor: 5000': " +
                          form->words);
}

}  // namespace highwall
