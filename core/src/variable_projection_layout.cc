#include "variable_projection.h"

#include <algorithm>
#include <utility>

// The memory of a VariableProjection, which is laid out once for all evaluations.
namespace highwall::internal {
namespace {

std::size_t ToSize(int i) {
  return static_cast<std::size_t>(i);
}

template <class T>
void Grow(std::vector<T>* memory, std::size_t size) {
  if (memory->size() < size) memory->resize(size);
}

}  // namespace

VariableProjection::VariableProjection(LandmarkProblem problem, double damping,
                                       FactorFaults* faults, Memory* memory)
    : problem_(std::move(problem)), damping_(damping), faults_(faults), memory_(*memory) {
  int columns = 0;
  std::size_t size = 0;
  memory_.column.clear(), memory_.place.clear(), memory_.plus.clear();
  for (const LandmarkProblem::Block& block : problem_.unknowns) {
    mutable_parameter_block_sizes()->push_back(block.size);
    memory_.column.push_back(columns);
    memory_.place.push_back(size);
    memory_.plus.emplace_back(block.size, block.tangent_size);
    columns += block.tangent_size;
    size += ToSize(block.size);
  }
  set_num_residuals(columns + 1);
  memory_.step.resize(columns);
  memory_.layouts.clear(), memory_.couplings.clear();
  memory_.column_of.resize(problem_.arguments.size());
  memory_.silent.assign(problem_.factors.size(), 0);
  std::size_t value = 0, feedback = 0;
  for (const LandmarkProblem::Landmark& landmark : problem_.landmarks) {
    LayOut(landmark);
    Memory::Layout& layout = memory_.layouts.back();
    layout.value = value;
    layout.feedback = feedback;
    value += ToSize(landmark.block.size);
    feedback += ToSize(landmark.block.tangent_size * (1 + layout.coupled));
  }
  for (Memory::State* state : {&memory_.accepted, &memory_.trial}) {
    state->valid = false;
    state->cost = 0.0;
    state->x.resize(size);
    state->landmarks.resize(value);
    state->costs.resize(problem_.landmarks.size());
    state->damping.assign(problem_.landmarks.size(), damping_);
    state->feedback.resize(feedback);
    state->H.resize(columns, columns);
    state->g.resize(columns);
    state->eliminated.resize(columns);
  }
}

// Lays out the couplings of the landmark and the memory for its factors.
void VariableProjection::LayOut(const LandmarkProblem::Landmark& landmark) {
  std::vector<Memory::Coupling>& couplings = memory_.couplings;
  Memory::Layout layout;
  layout.first_coupling = couplings.size();
  std::size_t all_rows = 0, numbers = 0;
  const auto for_each_unknown = [&](const auto& visit) {
    for (std::size_t f = landmark.first_factor; f < landmark.end_factor; ++f) {
      const std::size_t first = problem_.factors[f].first_argument;
      const std::size_t count = problem_.factors[f].cost->parameter_block_sizes().size();
      for (std::size_t a = first; a < first + count; ++a) {
        if (problem_.arguments[a].unknown >= 0) visit(problem_.arguments[a].unknown, a);
      }
    }
  };
  const auto first = [&] {
    return couplings.begin() + static_cast<std::ptrdiff_t>(layout.first_coupling);
  };
  const auto find = [&](int unknown) {
    return std::lower_bound(first(), couplings.end(), unknown,
                            [](const Memory::Coupling& c, int u) { return c.unknown < u; });
  };
  for_each_unknown([&](int unknown, std::size_t) {
    const auto at = find(unknown);
    if (at == couplings.end() || at->unknown != unknown) couplings.insert(at, {unknown, 0});
  });
  for (auto coupling = first(); coupling != couplings.end(); ++coupling) {
    const LandmarkProblem::Block& block = problem_.unknowns[ToSize(coupling->unknown)];
    coupling->column = layout.coupled;
    layout.coupled += block.tangent_size;
  }
  for_each_unknown(
      [&](int unknown, std::size_t a) { memory_.column_of[a] = find(unknown)->column; });
  for (std::size_t f = landmark.first_factor; f < landmark.end_factor; ++f) {
    const ceres::CostFunction& cost = *problem_.factors[f].cost;
    all_rows += ToSize(cost.num_residuals());
    numbers += ToSize(NumbersOf(cost));
    Grow(&memory_.parameters, cost.parameter_block_sizes().size());
    Grow(&memory_.jacobians, cost.parameter_block_sizes().size());
  }
  const std::size_t coupled = ToSize(layout.coupled), size = ToSize(landmark.block.size);
  Grow(&memory_.numbers, numbers);
  Grow(&memory_.of_landmark, all_rows * size);
  Grow(&memory_.weights, landmark.end_factor - landmark.first_factor);
  Grow(&memory_.tangent, all_rows * coupled);
  Grow(&memory_.weighted, all_rows * coupled);
  Grow(&memory_.coupling, size * coupled);
  Grow(&memory_.landmark_plus, size * size);
  Grow(&memory_.tried, size);
  layout.end_coupling = couplings.size();
  memory_.layouts.push_back(layout);
}

}  // namespace highwall::internal
