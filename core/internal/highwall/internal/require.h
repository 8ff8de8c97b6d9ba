#pragma once

#include <cmath>
#include <concepts>
#include <string>
#include <string_view>
#include <type_traits>

#include <highwall/core/error.h>
#include <highwall/internal/number_text.h>

// Checks of the common conditions of options. Each throws InvalidArgument with the given name, the
// requirement and the value; NaN fails all of them, infinity only those for finite values. For all
// other conditions: HIGHWALL_REQUIRE.
namespace [[gnu::visibility("default")]] highwall {

template <typename T>
concept Number = std::integral<T> || std::floating_point<T>;

namespace internal {

template <Number T>
std::string ValueText(T value) {
  if constexpr (std::floating_point<T>) {
    return FixedText(value);
  } else {
    return std::to_string(value);
  }
}

template <Number T>
void RequireValue(bool condition, T value, std::string_view name, const std::string& demand) {
  HIGHWALL_REQUIRE(condition, std::string(name) + " must " + demand + ", is " + ValueText(value));
}

}  // namespace internal

template <Number T>
void RequirePositive(T value, std::string_view name) {
  internal::RequireValue(value > T{0}, value, name, "be positive");
}

template <Number T>
void RequireNotNegative(T value, std::string_view name) {
  internal::RequireValue(value >= T{0}, value, name, "not be negative");
}

template <std::floating_point T>
void RequirePositiveFinite(T value, std::string_view name) {
  internal::RequireValue(std::isfinite(value) && value > T{0}, value, name, "be positive");
}

template <std::floating_point T>
void RequireNotNegativeFinite(T value, std::string_view name) {
  internal::RequireValue(std::isfinite(value) && value >= T{0}, value, name, "not be negative");
}

template <Number T>
void RequireAtLeast(T value, std::type_identity_t<T> least, std::string_view name) {
  internal::RequireValue(value >= least, value, name, "be at least " + internal::ValueText(least));
}

// low <= value <= high
template <Number T>
void RequireWithin(T value, std::type_identity_t<T> low, std::type_identity_t<T> high,
                   std::string_view name) {
  internal::RequireValue(
      value >= low && value <= high, value, name,
      "lie in [" + internal::ValueText(low) + ", " + internal::ValueText(high) + "]");
}

}  // namespace highwall
