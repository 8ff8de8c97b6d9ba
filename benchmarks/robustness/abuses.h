#pragma once

#include <vector>

#include "abused_sequence.h"

namespace highwall::bench {

// Returns all abuses of the benchmark, the empty one (`untouched`) first. second: the recording to
// which a camera is kidnapped; null: no kidnapping. It must outlive them.
std::vector<Abuse> AllAbuses(const Dataset* second);

}  // namespace highwall::bench
