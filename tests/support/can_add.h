#pragma once

#include <utility>

#include <highwall/core/variable.h>

namespace highwall {

// Satisfied if the call `graph.AddFactor(factor, variables...)` compiles for a pointer P to a
// factor and variables of types Ts.
template <class Graph, class P, class... Ts>
concept CanAdd = requires(Graph graph, P factor, Variable<Ts>... variables) {
  graph.AddFactor(std::move(factor), variables...);
};

}  // namespace highwall
