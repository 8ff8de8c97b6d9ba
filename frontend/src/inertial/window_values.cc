#include "inertial/window_values.h"

#include <algorithm>
#include <cmath>

namespace highwall {
namespace {

void OrderCalibrations(int first, const WindowUnknowns& unknowns, WindowLayout* layout) {
  layout->gravity = first;
  layout->cameras = first + WindowLayout::kGravity;
  layout->size = layout->cameras + unknowns.size();
}

}  // namespace

bool WindowValues::IsFinite() const {
  return gravity.vector().allFinite() && std::isfinite(time_offset) && T_BC.IsFinite() &&
         std::ranges::all_of(states, [](const WindowState& state) {
           return state.T_VB.IsFinite() && state.T_VW.IsFinite() && state.velocity.allFinite() &&
                  state.bias.allFinite();
         });
}

void WindowLayout::OrderByState(int states, const WindowUnknowns& unknowns) {
  head.clear(), tail.clear();
  for (int i = 0; i < states; ++i) {
    head.push_back(i * (WindowState::kHead + WindowState::kTail));
    tail.push_back(head.back() + WindowState::kHead);
  }
  inner = 0;
  OrderCalibrations(states * (WindowState::kHead + WindowState::kTail), unknowns, this);
}

void WindowLayout::OrderForSolver(int states, const WindowUnknowns& unknowns) {
  head.clear(), tail.clear();
  inner = (states - 1) * WindowState::kTail;
  for (int i = 0; i < states; ++i) {
    head.push_back(inner + i * WindowState::kHead);
    tail.push_back(i * WindowState::kTail);
  }
  tail.back() = inner + states * WindowState::kHead;
  OrderCalibrations(tail.back() + WindowState::kTail, unknowns, this);
}

void Plus(const WindowValues& from, const Eigen::VectorXd& step, const WindowLayout& layout,
          const WindowUnknowns& unknowns, WindowValues* to) {
  const PoseManifold pose;
  to->states.resize(from.states.size());
  for (std::size_t i = 0; i < from.states.size(); ++i) {
    const WindowState& before = from.states[i];
    WindowState& after = to->states[i];
    const double* const head = step.data() + layout.head[i];
    pose.Plus(before.T_VB.data(), head, after.T_VB.data());
    pose.Plus(before.T_VW.data(), head + 6, after.T_VW.data());
    after.velocity = before.velocity + step.segment<3>(layout.tail[i]);
    after.bias = before.bias + step.segment<6>(layout.tail[i] + 3);
  }
  UnitDirectionManifold().Plus(from.gravity.data(), step.data() + layout.gravity,
                               to->gravity.data());
  to->time_offset = from.time_offset;
  to->T_BC = from.T_BC;
  if (unknowns.time_offset) to->time_offset += step[layout.cameras];
  if (unknowns.T_BC) {
    pose.Plus(from.T_BC.data(), step.data() + layout.T_BC(unknowns), to->T_BC.data());
  }
}

void Minus(const WindowValues& values, const WindowValues& from, const WindowLayout& layout,
           const WindowUnknowns& unknowns, Eigen::VectorXd* step) {
  const PoseManifold pose;
  step->resize(layout.size);
  for (std::size_t i = 0; i < from.states.size(); ++i) {
    const WindowState &before = from.states[i], &after = values.states[i];
    double* const head = step->data() + layout.head[i];
    pose.Minus(after.T_VB.data(), before.T_VB.data(), head);
    pose.Minus(after.T_VW.data(), before.T_VW.data(), head + 6);
    step->segment<3>(layout.tail[i]) = after.velocity - before.velocity;
    step->segment<6>(layout.tail[i] + 3) = after.bias - before.bias;
  }
  UnitDirectionManifold().Minus(values.gravity.data(), from.gravity.data(),
                                step->data() + layout.gravity);
  if (unknowns.time_offset) (*step)[layout.cameras] = values.time_offset - from.time_offset;
  if (unknowns.T_BC) {
    pose.Minus(values.T_BC.data(), from.T_BC.data(), step->data() + layout.T_BC(unknowns));
  }
}

}  // namespace highwall
