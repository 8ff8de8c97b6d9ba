#pragma once

#include <cstddef>
#include <map>
#include <string>

namespace highwall::apps {

// Why most of the frames without a pose have none, and what helps: one sentence, or empty where
// every frame has a pose. reasons: SlamRun::loss_reasons. lost: how many frames they are.
std::string LossAdvice(const std::map<std::string, std::size_t>& reasons, std::size_t lost);

}  // namespace highwall::apps
