#pragma once

#include "engine/cones/cone_interior.h"
#include "engine/cones/cone_newton.h"
#include "engine/cones/gauss_seidel.h"

namespace lithe {

/// For what Gauss-Seidel takes thousands of sweeps over: stacks, heavy on light, redundant contacts. Each island of
/// contacts by itself, with its dense operator: the given impulses if they solve it; else Newton's method from there,
/// from where an interior point method ends, from some sweeps of Gauss-Seidel, from interior points by other ways, and
/// last from many sweeps, until one of them does. Exact to round-off. Cost: the cube of an island's rows.
///
/// Where contacts are redundant (a box on four corners) the impulses are not unique, what they do to the bodies is:
/// those of least Σ W_ii r_i² among those with the found sets of sticking, sliding and open contacts, if they lie in
/// the cones; else those found. Impulses given that solve the problem stay.
class DirectConeSolver final : public ConeSolver {
 public:
  struct Parameters {
    int most_rows = 1500;  // larger islands are Gauss-Seidel's alone
    int sweeps = 1000;     // of Gauss-Seidel, where nothing else helps
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
