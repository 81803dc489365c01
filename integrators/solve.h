#pragma once

#include "engine/study/solve.h"

namespace lithe {

/// solve() by the Automatic integrator, or generalized-alpha (index 3) with fixed steps.
///   auto answer = solve(graph, 1.0, {want(position(tip), percent(1))});
///   std::puts(answer.certificate.text().c_str());
Solution solve(SystemGraph& graph, double duration, const std::vector<Want>& wants, const SolveOptions& options = {});

}  // namespace lithe
