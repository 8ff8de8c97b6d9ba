#pragma once

namespace [[gnu::visibility("default")]] highwall {

// Options of the depth distortion estimate (docs/calibration.md).
struct DepthPatternOptions {
  bool enabled = true;
  int first = 12;  // >= 3: keyframes of a world at the first estimate
  int most = 60;   // >= 3: maximum number of keyframes used, the newest ones

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

}  // namespace highwall
