#pragma once

namespace [[gnu::visibility("default")]] highwall {

// Options of the depth distortion estimate (docs/calibration.md).
struct DepthPatternOptions {
  bool enabled = true;

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

}  // namespace highwall
