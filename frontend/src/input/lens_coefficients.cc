#include "input/lens_coefficients.h"

#include <algorithm>
#include <initializer_list>

namespace highwall {
namespace {

constexpr std::size_t kKnownCoefficients = 8;

bool IsZero(double value) {
  return value == 0.0;
}

void SetCoefficients(std::span<const double> values,
                     std::initializer_list<double PinholeCamera::*> names, PinholeCamera* camera) {
  auto value = values.begin();
  for (double PinholeCamera::*const name : names) {
    if (value == values.end()) return;
    camera->*name = *value++;
  }
}

}  // namespace

bool SetLens(std::string_view model, std::span<const double> coefficients, PinholeCamera* camera) {
  using C = PinholeCamera;
  if (model == "equidistant" || model == "fisheye" || model == "Kannala Brandt4") {
    camera->lens = LensModel::kEquidistant;
    SetCoefficients(coefficients, {&C::k1, &C::k2, &C::k3, &C::k4}, camera);
    return true;
  }
  if (std::ranges::all_of(coefficients, IsZero)) return true;
  if (model.empty() || model == "plumb_bob" || model == "rational_polynomial" ||
      model == "radtan" || model == "Brown Conrady" || model == "Modified Brown Conrady") {
    SetCoefficients(coefficients, {&C::k1, &C::k2, &C::p1, &C::p2, &C::k3, &C::k4, &C::k5, &C::k6},
                    camera);
    return true;
  }
  return false;
}

bool HasUnknownCoefficients(std::span<const double> coefficients) {
  return coefficients.size() > kKnownCoefficients &&
         !std::ranges::all_of(coefficients.subspan(kKnownCoefficients), IsZero);
}

}  // namespace highwall
