#include "run/imu_choice.h"

#include <string_view>

#include <highwall/core/error.h>
#include <highwall/internal/number_text.h>

namespace highwall::apps {
namespace {

constexpr std::string_view kFixed = "fixed:";

// Returns the error message; empty if the choice is valid.
std::string Problem(const std::string& choice) {
  if (choice == "off" || choice == "paper") return "";
  // Its name until version 0.2.
  if (choice == "consistent") return "consistent is what an IMU has by default: leave it out";
  const std::string problem = "must be off, paper or fixed:W, is " + choice;
  if (!choice.starts_with(kFixed)) return problem;
  const std::string weight = choice.substr(kFixed.size());
  const std::optional<double> value = ReadNumber<double>(weight);
  if (!value) return problem;
  return *value > 0.0 && *value <= 1000.0 ? "" : "W must be in (0, 1000], is " + weight;
}

}  // namespace

CLI::Validator ImuChoice() {
  return CLI::Validator(Problem, "");
}

std::optional<ImuWeightingOptions> ReadImuChoice(const std::string& choice) {
  ImuWeightingOptions weighting;
  if (choice.empty()) return weighting;
  const std::string problem = Problem(choice);
  HIGHWALL_REQUIRE(problem.empty(), "ReadImuChoice: " + problem);
  if (choice == "off") return std::nullopt;
  if (choice == "paper") weighting.policy = ImuWeighting::kPaper;
  if (choice.starts_with(kFixed)) {
    weighting.policy = ImuWeighting::kFixed;
    weighting.fixed_weight = *ReadNumber<double>(choice.substr(kFixed.size()));
  }
  return weighting;
}

}  // namespace highwall::apps
