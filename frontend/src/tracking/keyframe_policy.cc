#include <highwall/frontend/tracking/keyframe_policy.h>

namespace highwall {

KeyFramePolicy::~KeyFramePolicy() = default;

}  // namespace highwall
