#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <typeinfo>
#include <vector>

#include <ceres/cost_function.h>

#include <highwall/internal/cost_fault.h>

namespace highwall::internal {

// Readable for people.
std::string TypeName(const std::type_info& type);

// By row, of the first 64, of a factor that is SilentOutsideDomain: r = 0 and J = 0. None of any
// other. jacobians: as Evaluate() has filled them.
std::uint64_t SilentRows(const ceres::CostFunction& factor, const double* residuals,
                         double* const* jacobians);

// In place of what cannot be evaluated.
void FillWithZeros(const ceres::CostFunction& factor, double* residuals, double** jacobians);

// What happened to the factors of a graph.
struct FactorFaults {
  std::atomic<const ceres::CostFunction*> last = nullptr;  // that could not be evaluated
  // Where Ceres cannot linearize it ends, and prints: while it solves it is given zeros, and must
  // be stopped before it uses them.
  bool solving = false;
  int solve = 0;  // the number of this one
  std::atomic<bool> must_stop = false;
};

// Hands a factor to Ceres, which would print what is not finite and let an exception pass: both are
// no more than a factor that cannot be evaluated, and are noted.
class GuardedFactor final : public ceres::CostFunction {
 public:
  // Both must outlive it.
  GuardedFactor(const ceres::CostFunction& factor, FactorFaults* faults);
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

  const ceres::CostFunction& factor() const { return factor_; }

 private:
  // Rows that are silent now, and were not where Ceres was, cost more than they did there.
  // Constant: a landmark that went behind the camera neither pulls nor holds up the others.
  void PriceSilence(double const* const* parameters, double* residuals, double** jacobians) const;
  std::uint64_t SilentAt(double const* const* parameters, const double* residuals) const;

  const ceres::CostFunction& factor_;
  FactorFaults* const faults_;
  const bool is_priced_;  // it is SilentOutsideDomain
  // In the solve of that number: rows that were in their domain, and their residuals there.
  mutable int solve_ = 0;
  mutable std::uint64_t inside_ = 0;
  mutable std::vector<double> kept_;
};

// The factor itself, guarded or not.
const ceres::CostFunction& Unguarded(const ceres::CostFunction& factor);

}  // namespace highwall::internal
