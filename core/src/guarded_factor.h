#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <typeinfo>
#include <vector>

#include <ceres/cost_function.h>

#include <highwall/internal/cost_fault.h>

namespace highwall::internal {

// Returns the demangled, human-readable name.
std::string TypeName(const std::type_info& type);

// Returns a bit mask of the silent rows (r = 0 and J = 0) among the first 64 of a factor that is
// SilentOutsideDomain; 0 for any other factor. jacobians: as filled by Evaluate().
std::uint64_t SilentRows(const ceres::CostFunction& factor, const double* residuals,
                         double* const* jacobians);

// Returns false if the factor cannot be evaluated, throws, or gives values that are not finite or
// too large to be squared. jacobians: as in Evaluate().
bool EvaluatesWell(const ceres::CostFunction& factor, double const* const* parameters,
                   double* residuals, double** jacobians);

// Replaces the values of a factor that cannot be evaluated.
void FillWithZeros(const ceres::CostFunction& factor, double* residuals, double** jacobians);

// Evaluation faults of the factors of a graph.
struct FactorFaults {
  std::atomic<const ceres::CostFunction*> last = nullptr;  // last that could not be evaluated
  // Ceres terminates with a printed message if it cannot linearize a factor: during a solve such a
  // factor therefore returns zeros, and the solver must be stopped before it uses them.
  bool solving = false;
  int solve = 0;  // number of the current solve
  std::atomic<bool> must_stop = false;
};

// Wrapper that passes a factor to Ceres. Ceres would print values that are not finite and let an
// exception propagate: both are recorded as a factor that cannot be evaluated.
class GuardedFactor final : public ceres::CostFunction {
 public:
  // Both must outlive it.
  GuardedFactor(const ceres::CostFunction& factor, FactorFaults* faults);
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

  const ceres::CostFunction& factor() const { return factor_; }

 private:
  // Raises the cost of rows that are silent now but were not at the current point of Ceres. The
  // penalty is constant: a landmark that moved behind the camera neither pulls nor blocks the
  // others.
  void PriceSilence(double const* const* parameters, double* residuals, double** jacobians) const;
  std::uint64_t SilentAt(double const* const* parameters, const double* residuals) const;

  const ceres::CostFunction& factor_;
  FactorFaults* const faults_;
  const bool is_priced_;  // it is SilentOutsideDomain
  // In the solve of this number: the rows that were in their domain, and their residuals there.
  mutable int solve_ = 0;
  mutable std::uint64_t inside_ = 0;
  mutable std::vector<double> kept_;
};

// Returns the wrapped factor, or the factor itself if it is not wrapped.
const ceres::CostFunction& Unguarded(const ceres::CostFunction& factor);

}  // namespace highwall::internal
