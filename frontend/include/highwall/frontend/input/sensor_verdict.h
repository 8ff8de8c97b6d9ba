#pragma once

#include <string>
#include <vector>

namespace [[gnu::visibility("default")]] highwall {

// What the images and readings of a recording say about its configuration
// (docs/misconfiguration.md).

// A kind of contradiction between the configuration and what is measured.
enum class SensorFault {
  kDepthScale,         // depth factor or unit
  kDepthConstant,      // the same depth everywhere, or in every image
  kDepthSaturated,     // a stored value that stands for "no reading"
  kDepthByteOrder,     // the two bytes of the values are exchanged
  kDepthInverse,       // disparity or inverse depth instead of depth
  kDepthMirrored,      // flipped against the colour image
  kDepthUnregistered,  // shifted against the colour image, or of another field of view
  kDepthInconsistent,  // the motion of the image contradicts it
  kLens,               // focal lengths, principal point, distortion
  kImuMount,           // rotation of T_BC
  kImuLeverArm,        // translation of T_BC
  kImuAxes,            // exchanged or mirrored axes of the readings
  kImuSign,            // sign of a sensor
  kImuScale,           // unit of a sensor
  kImuClock,           // offset or rate of the stamps
  kImuReadings,        // faults of single readings: gaps, saturation, repetition
  kImuInconsistent,    // no single cause explains the contradiction
  kStamps,             // unit, order or rate of the stamps of images
  kMapNotMet,          // a given map was never recognized
  kEmptyMap,           // the dense map has no content
};

// Returns a name for files, such as "depth scale" or "imu mount".
const char* ToString(SensorFault fault);

// How far the results of a run may be trusted.
enum class Trust {
  kConsistent,  // nothing contradicts the configuration
  kDoubtful,    // usable, with less accuracy or less data than the recording holds
  kNotTrusted,  // trajectory or map are wrong
};

// Returns "consistent", "doubtful" or "not to be trusted".
const char* ToString(Trust trust);

// One contradiction.
struct SensorFinding {
  SensorFault fault = SensorFault::kDepthInconsistent;
  Trust trust = Trust::kDoubtful;  // what it leaves of the results
  std::string text{};              // what is wrong and by how much; a sentence without its period
  std::string remedy{};            // what to do, or the command that finds out; may be empty
};

// Returns "text: remedy", or the text alone.
std::string Line(const SensorFinding& finding);

// All that was found in a recording.
struct SensorVerdict {
  std::vector<SensorFinding> findings{};  // in the order in which they became significant

  // That of the worst finding.
  Trust trust() const;
  // Appends a finding unless there is one of the same kind, which it replaces if it is worse.
  // Returns whether the verdict has changed.
  bool Add(SensorFinding finding);
  // Returns one line: the trust, and the worst finding with the number of the others.
  std::string Summary() const;
};

}  // namespace highwall
