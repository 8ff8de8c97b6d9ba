#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>

#include <highwall/frontend/input/sensor_verdict.h>

namespace highwall::apps {

// Explains in one sentence why most of the frames without a pose have none, and what helps; empty
// if every frame has a pose. reasons: SlamRun::loss_reasons. lost: number of such frames.
std::string LossAdvice(const std::map<std::string, std::size_t>& reasons, std::size_t lost);

// Returns a finding if more than 40 % of the frames have no pose although their images show enough,
// as with fast motion and with depth that does not fit the colour images. reasons: as above.
std::optional<SensorFinding> UnexplainedLosses(const std::map<std::string, std::size_t>& reasons,
                                               std::size_t frames);

}  // namespace highwall::apps
