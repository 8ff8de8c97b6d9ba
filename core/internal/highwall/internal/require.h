#pragma once

#include <cmath>
#include <concepts>
#include <string>
#include <string_view>
#include <type_traits>

#include <highwall/core/error.h>

// The conditions that most options have to meet. Each throws InvalidArgument with the name as
// given, what is asked of it, its value and the place of the call; NaN meets none of them, infinity
// those that do not speak of finite values. For all other conditions: HIGHWALL_REQUIRE.
namespace [[gnu::visibility("default")]] highwall {

template <typename T>
concept Number = std::integral<T> || std::floating_point<T>;

namespace internal {

// Where a function was called that has Current() as the default of its last argument.
// (std::source_location needs clang 15.)
struct Place {
  const char* file;
  int line;

  static constexpr Place Current(const char* file = __builtin_FILE(), int line = __builtin_LINE()) {
    return {file, line};
  }
};

template <Number T>
void RequireValue(bool condition, const char* text, T value, std::string_view name,
                  const std::string& demand, Place place) {
  if (condition) return;
  ThrowInvalidArgument(place.file, place.line, text,
                       std::string(name) + " must " + demand + ", is " + std::to_string(value));
}

}  // namespace internal

template <Number T>
void RequirePositive(T value, std::string_view name,
                     internal::Place place = internal::Place::Current()) {
  internal::RequireValue(value > T{0}, "value > 0", value, name, "be positive", place);
}

template <Number T>
void RequireNotNegative(T value, std::string_view name,
                        internal::Place place = internal::Place::Current()) {
  internal::RequireValue(value >= T{0}, "value >= 0", value, name, "not be negative", place);
}

template <std::floating_point T>
void RequirePositiveFinite(T value, std::string_view name,
                           internal::Place place = internal::Place::Current()) {
  internal::RequireValue(std::isfinite(value) && value > T{0}, "0 < value < infinity", value, name,
                         "be positive", place);
}

template <std::floating_point T>
void RequireNotNegativeFinite(T value, std::string_view name,
                              internal::Place place = internal::Place::Current()) {
  internal::RequireValue(std::isfinite(value) && value >= T{0}, "0 <= value < infinity", value,
                         name, "not be negative", place);
}

template <Number T>
void RequireAtLeast(T value, std::type_identity_t<T> least, std::string_view name,
                    internal::Place place = internal::Place::Current()) {
  internal::RequireValue(value >= least, "value >= least", value, name,
                         "be at least " + std::to_string(least), place);
}

// low <= value <= high
template <Number T>
void RequireWithin(T value, std::type_identity_t<T> low, std::type_identity_t<T> high,
                   std::string_view name, internal::Place place = internal::Place::Current()) {
  internal::RequireValue(value >= low && value <= high, "low <= value <= high", value, name,
                         "lie in [" + std::to_string(low) + ", " + std::to_string(high) + "]",
                         place);
}

}  // namespace highwall
