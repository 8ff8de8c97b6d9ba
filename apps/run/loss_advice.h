#pragma once

#include <cstddef>
#include <map>
#include <string>

namespace highwall::apps {

// Explains in one sentence why most of the frames without a pose have none, and what helps; empty
// if every frame has a pose. reasons: SlamRun::loss_reasons. lost: number of such frames.
std::string LossAdvice(const std::map<std::string, std::size_t>& reasons, std::size_t lost);

}  // namespace highwall::apps
