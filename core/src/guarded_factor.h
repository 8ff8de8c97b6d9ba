#pragma once

#include <atomic>
#include <span>
#include <string>
#include <typeinfo>

#include <ceres/cost_function.h>

#include <highwall/internal/cost_fault.h>

namespace highwall::internal {

// Readable for people.
std::string TypeName(const std::type_info& type);

// Why a factor cannot be used there; empty if it can.
std::string FaultOf(const ceres::CostFunction& factor, std::span<const double* const> parameters);

// In place of what cannot be evaluated.
void FillWithZeros(const ceres::CostFunction& factor, double* residuals, double** jacobians);

// What happened to the factors of a graph.
struct FactorFaults {
  std::atomic<const ceres::CostFunction*> last = nullptr;  // that could not be evaluated
  // Where Ceres cannot linearize it ends, and prints: while it solves it is given zeros, and must
  // be stopped before it uses them.
  bool solving = false;
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
  const ceres::CostFunction& factor_;
  FactorFaults* const faults_;
};

// The factor itself, guarded or not.
const ceres::CostFunction& Unguarded(const ceres::CostFunction& factor);

}  // namespace highwall::internal
