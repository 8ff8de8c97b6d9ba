#include "guarded_factor.h"

#include <cxxabi.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <exception>
#include <memory>
#include <vector>

namespace highwall::internal {
namespace {

// Ceres fills what it hands out with 1e302, and takes that for a value that was not set.
bool IsSet(const double* values, int count) {
  constexpr double kLargest = 1e300;
  return std::all_of(values, values + count, [](double x) { return std::abs(x) < kLargest; });
}

bool EvaluatesWell(const ceres::CostFunction& factor, double const* const* parameters,
                   double* residuals, double** jacobians) {
  try {
    if (!factor.Evaluate(parameters, residuals, jacobians)) return false;
  } catch (const std::exception&) {
    return false;
  }
  const int rows = factor.num_residuals();
  if (!IsSet(residuals, rows)) return false;
  const std::vector<int>& sizes = factor.parameter_block_sizes();
  for (std::size_t i = 0; jacobians != nullptr && i < sizes.size(); ++i) {
    if (jacobians[i] != nullptr && !IsSet(jacobians[i], rows * sizes[i])) return false;
  }
  return true;
}

}  // namespace

std::string TypeName(const std::type_info& type) {
  int status = 0;
  const std::unique_ptr<char, decltype(&std::free)> name(
      abi::__cxa_demangle(type.name(), nullptr, nullptr, &status), &std::free);
  return status == 0 ? name.get() : type.name();
}

std::string FaultOf(const ceres::CostFunction& factor, std::span<const double* const> parameters) {
  const std::vector<int>& sizes = factor.parameter_block_sizes();
  const int rows = factor.num_residuals();
  std::vector<double> residuals(static_cast<std::size_t>(rows));
  std::vector<std::vector<double>> storage;
  std::vector<double*> jacobians;
  for (const int size : sizes) {
    storage.emplace_back(static_cast<std::size_t>(rows * size));
    jacobians.push_back(storage.back().data());
  }
  try {
    if (!factor.Evaluate(parameters.data(), residuals.data(), jacobians.data())) {
      return "cannot be evaluated";
    }
  } catch (const std::exception& error) {
    return std::string("throws: ") + error.what();
  }
  if (!IsSet(residuals.data(), rows)) return "has a residual that is not finite";
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    if (!IsSet(jacobians[i], rows * sizes[i])) {
      return "has a Jacobian that is not finite (block " + std::to_string(i) + ")";
    }
  }
  return "";
}

GuardedFactor::GuardedFactor(const ceres::CostFunction& factor, FactorFaults* faults)
    : factor_(factor), faults_(faults) {
  *mutable_parameter_block_sizes() = factor.parameter_block_sizes();
  set_num_residuals(factor.num_residuals());
}

bool GuardedFactor::Evaluate(double const* const* parameters, double* residuals,
                             double** jacobians) const {
  if (EvaluatesWell(factor_, parameters, residuals, jacobians)) return true;
  faults_->last = &factor_;
  if (!faults_->solving || jacobians == nullptr) return false;
  faults_->must_stop = true;
  std::fill_n(residuals, num_residuals(), 0.0);
  for (std::size_t i = 0; i < parameter_block_sizes().size(); ++i) {
    if (jacobians[i] == nullptr) continue;
    std::fill_n(jacobians[i], num_residuals() * parameter_block_sizes()[i], 0.0);
  }
  return true;
}

const ceres::CostFunction& Unguarded(const ceres::CostFunction& factor) {
  const auto* const guarded = dynamic_cast<const GuardedFactor*>(&factor);
  return guarded == nullptr ? factor : guarded->factor();
}

}  // namespace highwall::internal
