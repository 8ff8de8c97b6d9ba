#pragma once

#include <concepts>
#include <limits>
#include <string>
#include <string_view>
#include <type_traits>

#include <highwall/core/error.h>

// The option table of a struct is one function that visits each field with its range and unit:
//
//   void ForEachOption(OptionsOf<PyramidOptions> auto& options, const auto& visit) {
//     visit("levels", options.levels, Within(1, 16));
//     ...
//
// Validate() uses it, and so does the code that reads, writes or lists options. A group of options
// is visited as a field like any other.
namespace [[gnu::visibility("default")]] highwall {

// T, or const T.
template <class Given, class T>
concept OptionsOf = std::same_as<std::remove_const_t<Given>, T>;

// Allowed range of a number; NaN lies in no range. A field that is not a number has none.
struct OptionRange {
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
  bool above = false;  // min itself is excluded
  bool below = false;  // max itself is excluded
  std::string_view unit = "";

  constexpr OptionRange In(std::string_view name) const {
    OptionRange range = *this;
    range.unit = name;
    return range;
  }
  constexpr bool Contains(double value) const {
    return (above ? value > min : value >= min) && (below ? value < max : value <= max);
  }
  // "> 0", ">= 1", "in (0, 1]".
  std::string ToString() const;
};

constexpr OptionRange Within(double min, double max) {
  return {.min = min, .max = max};
}
constexpr OptionRange AtLeast(double min) {
  return {.min = min};
}
constexpr OptionRange Above(double min) {
  return {.min = min, .above = true};
}
constexpr OptionRange Positive() {
  return Above(0.0);
}
// Excludes infinity.
constexpr OptionRange Finite(OptionRange range) {
  range.below = true;
  return range;
}
// (min, max]
constexpr OptionRange AboveTo(double min, double max) {
  return {.min = min, .max = max, .above = true};
}
// (min, max)
constexpr OptionRange Between(double min, double max) {
  return {.min = min, .max = max, .above = true, .below = true};
}
// A fraction: [0, 1], or (0, 1] where zero makes no sense.
constexpr OptionRange Share() {
  return Within(0.0, 1.0);
}
constexpr OptionRange PositiveShare() {
  return AboveTo(0.0, 1.0);
}

// Returns the value in the usual notation: 0.05, 20.
std::string FormatOption(double value);

// Number of values of an enum that is an option; ToString() names them.
template <class Enum>
inline constexpr int kChoices = 0;  // specialized for each such enum

template <class Field>
concept RangedOption = std::is_arithmetic_v<Field> && !std::is_same_v<Field, bool> &&
                       !std::is_unsigned_v<Field>;  // unsigned: a seed

// Name of a group of options among its owners, "Options::group", which only an error composes.
struct OptionPath {
  const OptionPath* owner = nullptr;
  std::string_view name;

  std::string ToString() const {
    return (owner != nullptr ? owner->ToString() + "::" : "") + std::string(name);
  }
};

// Throws InvalidArgument for a field that is out of its range, "name::field must be > 0, is -1",
// and the exceptions of its groups of options.
template <class Options>
void RequireInRange(const Options& options, const OptionPath& path) {
  ForEachOption(options,
                [&](std::string_view field, const auto& value, const OptionRange& range = {}) {
                  using Field = std::remove_cvref_t<decltype(value)>;
                  const OptionPath of_field{&path, field};
                  if constexpr (requires { value.Validate(); }) {
                    value.Validate();
                  } else if constexpr (std::is_class_v<Field>) {
                    RequireInRange(value, of_field);
                  } else if constexpr (RangedOption<Field>) {
                    HIGHWALL_REQUIRE(range.Contains(static_cast<double>(value)),
                                     of_field.ToString() + " must be " + range.ToString() +
                                         ", is " + FormatOption(static_cast<double>(value)));
                  }
                });
}
template <class Options>
void RequireInRange(const Options& options, std::string_view name) {
  RequireInRange(options, OptionPath{nullptr, name});
}

}  // namespace highwall
