#pragma once

#include <optional>
#include <string>

#include <CLI/Error.hpp>
#include <CLI/Validators.hpp>

#include <highwall/frontend/inertial/options.h>

namespace highwall::apps {

// Of an option: off, paper, consistent, or fixed:W with a weight W in (0, 1000].
CLI::Validator ImuChoice();

// How such a choice weighs the IMU, empty for "off"; the default where it is empty. Throws
// InvalidArgument for what ImuChoice() refuses.
std::optional<ImuWeightingOptions> ReadImuChoice(const std::string& choice);

}  // namespace highwall::apps
