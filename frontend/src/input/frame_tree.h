#pragma once

#include <map>
#include <optional>
#include <string>

#include <highwall/core/pose.h>

#include "input/bag_file.h"

namespace highwall {

// The fixed transforms between the frames of a recording.
class FrameTree {
 public:
  // T: T_ab.
  void Add(const std::string& a, const std::string& b, const Pose& T);
  // Returns T_ab along the frames between; nothing if none connect the two.
  std::optional<Pose> Find(const std::string& a, const std::string& b) const;

 private:
  std::map<std::string, std::map<std::string, Pose>> neighbours_;  // T_ab by a and b
};

// Reads /tf_static and, in a bag of the SDK of RealSense, the transforms of its streams. Throws
// IoError if a message is damaged.
FrameTree ReadFrameTree(const BagFile& bag);

// Returns the frame of a stream in that tree. frame: of the header of its messages.
std::string FrameOf(const BagFile& bag, const std::string& topic, const std::string& frame);

}  // namespace highwall
