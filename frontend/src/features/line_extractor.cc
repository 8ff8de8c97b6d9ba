#include <highwall/frontend/features/line_extractor.h>

namespace highwall {

LineExtractor::~LineExtractor() = default;

}  // namespace highwall
