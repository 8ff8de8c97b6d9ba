#include "bench_loops.h"

#include <chrono>
#include <random>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

namespace highwall::bench {

nlohmann::json BenchCorrection(int keyframes) {
  return {{"keyframes", keyframes}};
}

}  // namespace highwall::bench
