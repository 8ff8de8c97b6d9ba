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
  // Likewise, of one that is not stated to be fixed: it counts only where no others connect.
  void AddConstant(const std::string& a, const std::string& b, const Pose& T);
  // Returns T_ab along the frames between; nothing if none connect the two.
  std::optional<Pose> Find(const std::string& a, const std::string& b) const;

 private:
  using Neighbours = std::map<std::string, std::map<std::string, Pose>>;  // T_ab by a and b

  static std::optional<Pose> FindIn(const Neighbours& tree, const std::string& a,
                                    const std::string& b);

  Neighbours fixed_, all_;
};

// Reads /tf_static and, in a bag of the SDK of RealSense, the transforms of its streams; and the
// transforms of /tf that never change in some of its messages, which are spread over the recording:
// the static publishers of ROS 1 may write there. Throws IoError if a message of the former is
// damaged.
FrameTree ReadFrameTree(const BagFile& bag);

// Returns the frame of a stream in that tree. frame: of the header of its messages.
std::string FrameOf(const BagFile& bag, const std::string& topic, const std::string& frame);

}  // namespace highwall
