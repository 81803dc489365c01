#pragma once

#include "engine/cones/cone_interior.h"
#include "engine/cones/cone_newton.h"
#include "engine/cones/gauss_seidel.h"

namespace lithe {

/// For problems that take Gauss-Seidel thousands of sweeps: stacks, heavy on light bodies, redundant contacts. Solves
/// each island of contacts with its dense operator. It keeps the given impulses if they solve the island; otherwise it
/// starts Newton's method from these, from the result of an interior point method, from some sweeps of Gauss-Seidel,
/// from other interior points, and last from many sweeps, until one succeeds. Exact to round-off. Cost: the cube of an
/// island's rows.
///
/// If contacts are redundant (a box on four corners), the impulses are not unique, but their effect on the bodies is.
/// The result has the least Σ W_ii r_i² among those with the found sets of sticking, sliding and open contacts, if they
/// lie in the cones; else those found. Impulses given that solve the problem stay.
class DirectConeSolver final : public ConeSolver {
 public:
  struct Parameters {
    int most_rows = 1500;  // larger islands are solved by Gauss-Seidel alone
    int sweeps = 1000;     // of Gauss-Seidel, if the other methods fail
  };
  DirectConeSolver() = default;
  explicit DirectConeSolver(Parameters parameters) : parameters_(parameters) {}

  std::string name() const override { return "direct"; }
  /// Iterations: factorisations, of the island with the most. Impulses exact to round-off (1e-13 of the largest) count
  /// as converged, whatever the tolerance.
  ConeResult solve(const ConeProblem& problem, double tolerance, VectorX& r) override;
  std::unique_ptr<ConeSolver> clone() const override { return std::make_unique<DirectConeSolver>(parameters_); }

 private:
  ConeResult solve_island(const ConeProblem& island, double tolerance, VectorX& r);

  Parameters parameters_;
  ConeNewton newton_;
  ConeInterior interior_;
};

/// Gauss-Seidel first; islands that some sweeps do not bring to the tolerance go to the direct solver.
class AutomaticConeSolver final : public ConeSolver {
 public:
  struct Parameters {
    int sweeps = 30;
    DirectConeSolver::Parameters direct{.most_rows = 600, .sweeps = 50};
  };
  AutomaticConeSolver() : AutomaticConeSolver(Parameters()) {}
  explicit AutomaticConeSolver(Parameters parameters)
      : parameters_(parameters), sweeps_({.sweeps = parameters.sweeps}), direct_(parameters.direct) {}

  std::string name() const override { return "automatic"; }
  ConeResult solve(const ConeProblem& problem, double tolerance, VectorX& r) override;
  std::unique_ptr<ConeSolver> clone() const override { return std::make_unique<AutomaticConeSolver>(parameters_); }

 private:
  Parameters parameters_;
  GaussSeidel sweeps_;
  DirectConeSolver direct_;
};

}  // namespace lithe
