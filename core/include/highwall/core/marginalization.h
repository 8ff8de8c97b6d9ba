#pragma once

#include <memory>
#include <span>
#include <vector>

#include <highwall/core/marginal_prior.h>

namespace ceres {
class Problem;
}  // namespace ceres

namespace highwall {

struct MarginalizationOptions {
  // A direction counts as unobserved where its pivot, for Jacobian columns scaled to unit length,
  // is below this. In (0, 1).
  double rank_tolerance = 1e-10;
  // Blocks under a MarginalPrior are linearized where that prior was, so that unobservable
  // directions gain no information from one marginalization to the next (docs/marginalization.md,
  // section "First-estimate Jacobians").
  bool first_estimate_jacobians = false;
  // Blocks that are linearized at their present value nevertheless: calibration.
  std::vector<const double*> relinearized = {};

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

struct MarginalizationReport {
  int factors = 0;             // residual blocks that were linearized
  int rows = 0;                // their residuals
  int removed_dimensions = 0;  // tangent dimensions of the removed blocks
  int removed_rank = 0;        // of these, those that the factors observe
  int dimensions = 0;          // tangent dimensions of the blocks under the prior
  int rank = 0;                // of the prior
  int null_space = 0;          // dimensions - rank: directions the prior says nothing about
  // Largest over smallest singular value of the prior's A with columns scaled to unit length.
  double condition = 1.0;
};

struct Marginal {
  std::unique_ptr<MarginalPrior> prior;  // null: nothing is known of the blocks that stay
  std::vector<double*> blocks;           // of the prior, in its order
  MarginalizationReport report;
};

// The prior on the blocks that stay which stands for `removed` and every residual that touches
// them, linearized at the present values with losses applied. Fixed blocks are known: they are in
// no prior. An earlier MarginalPrior is a residual like any other. The problem is not changed; to
// put the prior in place of what it stands for:
//
//   Marginal marginal = Marginalize(problem, removed);
//   for (double* block : removed) problem.RemoveParameterBlock(block);  // and its residuals
//   if (marginal.prior) {
//     problem.AddResidualBlock(marginal.prior.release(), nullptr, marginal.blocks);
//   }
//
// Works on any ceres::Problem without an EvaluationCallback. The prior refers to the manifolds
// of the problem. Landmarks cost one small QR each: no matrix over all of them is ever formed.
// Throws InvalidArgument if a block is not in the problem or given twice, or if a residual cannot
// be evaluated or is not finite.
Marginal Marginalize(const ceres::Problem& problem, std::span<double* const> removed,
                     const MarginalizationOptions& options = {});

// The prior on `kept` that stands for the whole problem: all other blocks are marginalized.
// Exceptions as above.
Marginal Summarize(const ceres::Problem& problem, std::span<double* const> kept,
                   const MarginalizationOptions& options = {});

}  // namespace highwall
