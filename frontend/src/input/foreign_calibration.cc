#include "input/foreign_calibration.h"

#include <algorithm>
#include <cctype>
#include <set>
#include <vector>

#include <highwall/internal/number_text.h>

namespace highwall {
namespace {

using Keys = std::set<std::string>;

struct ForeignForm {
  const char* name;
  std::vector<Keys> marks;  // each has an alternative among the keys of the text
  const char* words;        // how the file provides the required values
};

const std::vector<ForeignForm>& ForeignForms() {
  static const std::vector<ForeignForm> kForms = {
      {"a settings file of ORB-SLAM",
       {{"Camera.fx", "Camera1.fx"}},
       "width, height, fx to cy and k1 to k3 are its Camera.width to Camera.k3 (Camera1.fx and so "
       "on in ORB-SLAM3), depth_factor its DepthMapFactor"},
      {"a camera chain of Kalibr",
       {{"cam0"}, {"intrinsics"}},
       "fx, fy, cx, cy are its intrinsics, width and height its resolution, and k1, k2, p1, p2 its "
       "distortion_coeffs if distortion_model is radtan; T_BC of an IMU is the inverse of "
       "T_cam_imu"},
      {"a sensor.yaml of EuRoC",
       {{"sensor_type"}, {"intrinsics"}},
       "fx, fy, cx, cy are its intrinsics, width and height its resolution, and k1, k2, p1, p2 its "
       "distortion_coefficients"},
      {"a camera_info of ROS",
       {{"camera_matrix", "K", "k"}, {"image_width", "distortion_model", "projection_matrix"}},
       "width and height are its image_width and image_height, fx, cx, fy, cy the numbers 1, 3, 5 "
       "and 6 of its camera_matrix (K), and k1, k2, p1, p2, k3 its distortion_coefficients (D) if "
       "the model is plumb_bob"},
      {"an intrinsic of Open3D",
       {{"intrinsic_matrix"}},
       "width and height are its own, and fx, fy, cx, cy the numbers 1, 5, 7 and 8 of its "
       "intrinsic_matrix, which stands there column by column"},
      {"the intrinsics of librealsense",
       {{"ppx"}, {"ppy"}},
       "width, height, fx and fy are its own, cx and cy its ppx and ppy, and k1, k2, p1, p2, k3 "
       "its "
       "coeffs"},
      {"a file of OpenCV's FileStorage",
       {{"!!opencv-matrix"}},
       "fx, cx, fy, cy are the numbers 1, 3, 5 and 6 of the camera matrix, and k1, k2, p1, p2, k3 "
       "the distortion coefficients"},
  };
  return kForms;
}

// Returns the words before a colon, and the tag of OpenCV's matrices; comments are ignored.
Keys KeysOf(const std::string& text) {
  Keys keys;
  TextReader lines(text);
  const auto is_of_word = [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '.';
  };
  for (std::string line; std::getline(lines, line);) {
    line.resize(std::min(line.find('#'), line.size()));
    if (line.find("!!opencv-matrix") != std::string::npos) keys.insert("!!opencv-matrix");
    for (std::size_t colon = line.find(':'); colon != std::string::npos;
         colon = line.find(':', colon + 1)) {
      std::size_t end = colon;
      while (end > 0 && (line[end - 1] == ' ' || line[end - 1] == '"')) --end;
      std::size_t begin = end;
      while (begin > 0 && is_of_word(line[begin - 1])) --begin;
      if (begin < end) keys.insert(line.substr(begin, end - begin));
    }
  }
  return keys;
}

}  // namespace

std::optional<std::string> DescribeForeignCalibration(const std::string& text) {
  const Keys keys = KeysOf(text);
  if (keys.contains("camera")) return std::nullopt;
  for (const ForeignForm& form : ForeignForms()) {
    const bool fits = std::ranges::all_of(form.marks, [&](const Keys& mark) {
      return std::ranges::any_of(mark, [&](const std::string& key) { return keys.contains(key); });
    });
    if (!fits) continue;
    return std::string("is ") + form.name +
           ", which is not read; write 'camera: {width: 640, height: 480, fx: 525, fy: 525, cx: "
           "319.5, cy: 239.5}' (with k1, k2, p1, p2, k3 of a lens) and 'depth_factor: 5000': " +
           form.words;
  }
  return std::nullopt;
}

}  // namespace highwall
