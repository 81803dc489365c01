#pragma once

#include <array>
#include <vector>

#include "tests/support/methods.h"
#include "tests/support/scenes.h"

/// Scenes without jumps, rigid and flexible, for methods of high order, and what a run errs by in them.
namespace lithe::test {

struct SmoothScene {
  const char* name;
  Scene (*make)();
  double end;  // s; fixed steps are parts of a fifth of it
};

extern const std::array<SmoothScene, 5> kSmoothScenes;

struct RunErrors {
  double q, v, lambda;  // largest difference; λ relative
};

RunErrors run_difference(const State& a, const State& b);

/// The states of a run at five times, the last of them the end.
std::vector<State> five_states(const SmoothScene& smooth, Method method);

/// Largest differences of two such runs.
RunErrors run_difference(const std::vector<State>& a, const std::vector<State>& b);

}  // namespace lithe::test
