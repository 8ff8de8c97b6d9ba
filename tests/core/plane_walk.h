#pragma once

#include <algorithm>
#include <vector>

#include <highwall/core/sliding_window_smoother.h>

#include "plane_steps.h"
#include "random_states.h"

namespace highwall {

// A planar walk past landmarks in which every quantity is drawn once. Feeds smoothers of any lag.
struct Walk {
  explicit Walk(SlidingWindowSmoother* s) : smoother(s), random(5) {}
  void Advance() {
    const int k = static_cast<int>(states.size());
    states.push_back(smoother->AddState(Stamp{k} * 100, Vector2(random.Uniform(-9, 9), 0.0)));
    const Vector2 z(1.0 + random.Uniform(-0.2, 0.2), random.Uniform(-0.2, 0.2));
    if (k == 0) {
      smoother->AddFactor(MakePrior(z, 2.0), states[0]);
    } else {
      smoother->AddFactor(MakeStep(z, 1.5), states[states.size() - 2], states.back());
    }
    if (k % 2 == 0) landmarks.push_back(AddLandmark(Vector2(0, 0)));
    // Each landmark is observed from the first four states from its creation on.
    for (std::size_t j = landmarks.size() - std::min<std::size_t>(2, landmarks.size());
         j < landmarks.size(); ++j) {
      const Vector2 seen(random.Uniform(-1, 1), random.Uniform(-1, 1));
      smoother->AddFactor(MakeStep(seen, 0.7), states.back(), landmarks[j]);
    }
  }
  virtual Variable<Vector2> AddLandmark(const Vector2& x) { return smoother->AddLandmark(x); }
  virtual ~Walk() = default;

  SlidingWindowSmoother* smoother;
  RandomStates random;
  std::vector<Variable<Vector2>> states, landmarks;
};

}  // namespace highwall
