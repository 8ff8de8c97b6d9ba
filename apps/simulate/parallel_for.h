#pragma once

#include <functional>

namespace highwall::simulate {

// Calls body(i) for every i in [0, count), on `threads` threads (0: one per processor). Returns
// when all are done; the first exception of a body stops the others early and is rethrown.
void ParallelFor(int count, int threads, const std::function<void(int)>& body);

}  // namespace highwall::simulate
