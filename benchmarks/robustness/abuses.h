#pragma once

#include <vector>

#include "abused_sequence.h"

namespace highwall::bench {

// Every abuse that the benchmark knows, the empty one (`untouched`) first. second: the recording
// that a kidnapped camera is taken to; null: nobody is kidnapped. It must outlive them.
std::vector<Abuse> AllAbuses(const Dataset* second);

}  // namespace highwall::bench
