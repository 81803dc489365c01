#pragma once

#include "engine/cones/cone_problem.h"
#include "tools/stability/methods/dense_equations.h"

namespace lithe::lab {

/// Every contact that would close held as by a joint, u = 0 with impulses of least norm that may pull: what impact laws
/// do that take restitution zero at all points in touch for equations.
class HeldContacts final : public ConeSolver {
 public:
  std::string name() const override { return "held"; }
  ConeResult solve(const ConeProblem& problem, double, VectorX& r) override {
    const MatrixX W = problem.delassus();
    std::vector<int> held;
    for (const ConeProblem::Contact& c : problem.contacts)
      if (problem.free[c.row] < 0)
        for (int k = 0; k < c.rows; ++k) held.push_back(c.row + k);
    r.setZero(problem.rows);
    if (held.empty()) return {.converged = true};
    r(held) = least_norm(W(held, held), -problem.free(held), 1e-10).x;
    return {.converged = true, .iterations = 1};
  }
  std::unique_ptr<ConeSolver> clone() const override { return std::make_unique<HeldContacts>(); }
};

}  // namespace lithe::lab
