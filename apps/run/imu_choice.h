#pragma once

#include <optional>
#include <string>

#include <CLI/Error.hpp>
#include <CLI/Validators.hpp>

#include <highwall/frontend/inertial/options.h>

namespace highwall::apps {

// Validates an option: off, paper, or fixed:W with a weight W in (0, 1000].
CLI::Validator ImuChoice();

// Returns the IMU weighting of such a choice: empty for "off"; the default, which has no name, if
// the choice is empty. Throws InvalidArgument for values that ImuChoice() rejects.
std::optional<ImuWeightingOptions> ReadImuChoice(const std::string& choice);

}  // namespace highwall::apps
