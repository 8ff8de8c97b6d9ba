#pragma once

#include <string>

#include "slam_run.h"

namespace highwall::apps {

// Why most of the frames without a pose have none, and what helps: one sentence, or empty where
// every frame has a pose.
std::string LossAdvice(const SlamRun& run);

}  // namespace highwall::apps
