#include <highwall/frontend/features/options.h>

#include <highwall/core/error.h>
#include <highwall/frontend/features/option_table.h>

namespace highwall {

void PyramidOptions::Validate() const {
  RequireInRange(*this, "PyramidOptions");
}

void OrbExtractorOptions::Validate() const {
  RequireInRange(*this, "OrbExtractorOptions");
}

void SiftExtractorOptions::Validate() const {
  RequireInRange(*this, "SiftExtractorOptions");
}

void LineExtractorOptions::Validate() const {
  RequireInRange(*this, "LineExtractorOptions");
}

void FrameBuilderOptions::Validate() const {
  RequireInRange(*this, "FrameBuilderOptions");
  HIGHWALL_REQUIRE(use_points || use_lines,
                   "FrameBuilderOptions: use_points and use_lines are both off");
}

void LineMatcherOptions::Validate() const {
  RequireInRange(*this, "LineMatcherOptions");
}

const char* ToString(PointDetector detector) {
  return detector == PointDetector::kOrb ? "orb" : "sift";
}

const char* ToString(LineDetector detector) {
  return detector == LineDetector::kLsd ? "lsd" : "edlines";
}

const char* ToString(MadRule rule) {
  return rule == MadRule::kMedian ? "median" : "paper";
}

}  // namespace highwall
