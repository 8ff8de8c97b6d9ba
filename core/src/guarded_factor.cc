#include "guarded_factor.h"

#include <cxxabi.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <exception>
#include <memory>
#include <numeric>
#include <vector>

#include <Eigen/Core>

#include <highwall/core/silent_domain.h>

namespace highwall::internal {
namespace {

// Sums of squares of smaller values do not overflow.
constexpr double kLargest = 1e150;

bool AreSmall(const double* values, int count) {
  // The sum is faster than the maximum and above it, and not a number if one value is not. Four
  // sums do not wait for each other.
  std::array<double, 4> sums{};
  int i = 0;
  for (; i + 4 <= count; i += 4) {
    for (int k = 0; k < 4; ++k) sums[static_cast<std::size_t>(k)] += std::abs(values[i + k]);
  }
  for (; i < count; ++i) sums[0] += std::abs(values[i]);
  if ((sums[0] + sums[1]) + (sums[2] + sums[3]) < kLargest) return true;
  const Eigen::Map<const Eigen::ArrayXd> all(values, count);
  return all.abs().maxCoeff<Eigen::PropagateNaN>() < kLargest;
}

// Describes values that are not small. Ceres initializes its output arrays with 1e302.
std::string FaultOf(const double* values, int count) {
  constexpr double kUnset = 1e300;
  const bool finite =
      std::all_of(values, values + count, [](double x) { return std::abs(x) < kUnset; });
  return finite ? "that is too large to be squared" : "that is not finite";
}

// Necessary condition that can be checked without Jacobians and rarely holds.
bool MayBeSilent(const ceres::CostFunction& factor, const double* residuals) {
  const double* const end = residuals + factor.num_residuals();
  return std::find(residuals, end, 0.0) != end &&
         dynamic_cast<const SilentOutsideDomain*>(&factor) != nullptr;
}

}  // namespace

bool EvaluatesWell(const ceres::CostFunction& factor, double const* const* parameters,
                   double* residuals, double** jacobians) {
  try {
    if (!factor.Evaluate(parameters, residuals, jacobians)) return false;
  } catch (...) {  // a user factor may throw anything, and Ceres' threads let nothing pass
    return false;
  }
  const int rows = factor.num_residuals();
  if (!AreSmall(residuals, rows)) return false;
  const std::vector<int>& sizes = factor.parameter_block_sizes();
  for (std::size_t i = 0; jacobians != nullptr && i < sizes.size(); ++i) {
    if (jacobians[i] != nullptr && !AreSmall(jacobians[i], rows * sizes[i])) return false;
  }
  return true;
}

std::uint64_t SilentRows(const ceres::CostFunction& factor, const double* residuals,
                         double* const* jacobians) {
  if (!MayBeSilent(factor, residuals)) return 0;
  const std::vector<int>& sizes = factor.parameter_block_sizes();
  std::uint64_t silent = 0;
  for (int row = 0; row < std::min(factor.num_residuals(), 64); ++row) {
    if (residuals[row] != 0.0) continue;
    bool is_silent = true;
    for (std::size_t i = 0; is_silent && i < sizes.size(); ++i) {
      if (jacobians[i] == nullptr) continue;
      const double* const J = jacobians[i] + row * sizes[i];
      is_silent = std::all_of(J, J + sizes[i], [](double x) { return x == 0.0; });
    }
    if (is_silent) silent |= std::uint64_t{1} << row;
  }
  return silent;
}

void FillWithZeros(const ceres::CostFunction& factor, double* residuals, double** jacobians) {
  const std::vector<int>& sizes = factor.parameter_block_sizes();
  std::fill_n(residuals, factor.num_residuals(), 0.0);
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    if (jacobians[i] != nullptr) std::fill_n(jacobians[i], factor.num_residuals() * sizes[i], 0.0);
  }
}

std::string TypeName(const std::type_info& type) {
  int status = 0;
  const std::unique_ptr<char, decltype(&std::free)> demangled(
      abi::__cxa_demangle(type.name(), nullptr, nullptr, &status), &std::free);
  const std::string name = status == 0 ? demangled.get() : type.name();
  const std::string matrix = "Eigen::Matrix<double, ";
  if (!name.starts_with(matrix)) return name;
  return "vector of " + name.substr(matrix.size(), name.find(',', matrix.size()) - matrix.size());
}

std::string FaultOf(const ceres::CostFunction& factor, std::span<const double* const> parameters) {
  const std::vector<int>& sizes = factor.parameter_block_sizes();
  const int rows = factor.num_residuals();
  const int columns = std::accumulate(sizes.begin(), sizes.end(), 0);
  std::vector<double> values(static_cast<std::size_t>(rows) *
                             static_cast<std::size_t>(1 + columns));
  double* const residuals = values.data();
  double* next = residuals + rows;
  std::vector<double*> jacobians;
  jacobians.reserve(sizes.size());
  for (const int size : sizes) {
    jacobians.push_back(next);
    next += rows * size;
  }
  try {
    // Without Jacobians last, as a solver evaluates a trial step.
    for (double** const wanted : {jacobians.data(), static_cast<double**>(nullptr)}) {
      if (!factor.Evaluate(parameters.data(), residuals, wanted)) return "cannot be evaluated";
    }
  } catch (const std::exception& error) {
    return std::string("throws: ") + error.what();
  } catch (...) {
    return "throws an object that is no std::exception";
  }
  if (!AreSmall(residuals, rows)) return "has a residual " + FaultOf(residuals, rows);
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    if (!AreSmall(jacobians[i], rows * sizes[i])) {
      return "has a Jacobian " + FaultOf(jacobians[i], rows * sizes[i]) + " (block " +
             std::to_string(i) + ")";
    }
  }
  return "";
}

GuardedFactor::GuardedFactor(const ceres::CostFunction& factor, FactorFaults* faults)
    : factor_(factor),
      faults_(faults),
      is_priced_(dynamic_cast<const SilentOutsideDomain*>(&factor) != nullptr) {
  *mutable_parameter_block_sizes() = factor.parameter_block_sizes();
  set_num_residuals(factor.num_residuals());
}

bool GuardedFactor::Evaluate(double const* const* parameters, double* residuals,
                             double** jacobians) const {
  if (EvaluatesWell(factor_, parameters, residuals, jacobians)) {
    if (is_priced_ && faults_->solving) PriceSilence(parameters, residuals, jacobians);
    return true;
  }
  faults_->last = &factor_;
  if (!faults_->solving || jacobians == nullptr) return false;
  faults_->must_stop = true;
  FillWithZeros(*this, residuals, jacobians);
  return true;
}

void GuardedFactor::PriceSilence(double const* const* parameters, double* residuals,
                                 double** jacobians) const {
  if (solve_ != faults_->solve) {
    if (jacobians == nullptr) return;  // the solve has not linearized this factor yet
    solve_ = faults_->solve;
    inside_ = 0;
    kept_.assign(static_cast<std::size_t>(num_residuals()), 0.0);
  }
  const std::uint64_t silent = jacobians != nullptr ? SilentRows(factor_, residuals, jacobians)
                                                    : SilentAt(parameters, residuals);
  for (std::size_t row = 0; row < std::min<std::size_t>(kept_.size(), 64); ++row) {
    const std::uint64_t bit = std::uint64_t{1} << row;
    if ((silent & inside_ & bit) != 0) {
      residuals[row] = kept_[row] + std::copysign(1.0, kept_[row]);
    } else if (jacobians != nullptr && (silent & bit) == 0) {
      kept_[row] = residuals[row];
      inside_ |= bit;
    }
  }
}

std::uint64_t GuardedFactor::SilentAt(double const* const* parameters,
                                      const double* residuals) const {
  if (inside_ == 0 || !MayBeSilent(factor_, residuals)) return 0;
  std::vector<std::vector<double>> values;
  std::vector<double*> jacobians;
  for (const int size : parameter_block_sizes()) {
    values.emplace_back(static_cast<std::size_t>(num_residuals() * size));
    jacobians.push_back(values.back().data());
  }
  std::vector<double> again(static_cast<std::size_t>(num_residuals()));
  if (!EvaluatesWell(factor_, parameters, again.data(), jacobians.data())) return 0;
  return SilentRows(factor_, residuals, jacobians.data());
}

const ceres::CostFunction& Unguarded(const ceres::CostFunction& factor) {
  const auto* const guarded = dynamic_cast<const GuardedFactor*>(&factor);
  return guarded == nullptr ? factor : guarded->factor();
}

}  // namespace highwall::internal
