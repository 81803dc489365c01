#pragma once

#include <array>
#include <span>
#include <string_view>

namespace lithe {

/// Coefficients of an explicit Runge-Kutta method with an error estimate, whose last stage is the end of the step.
struct RungeKuttaTableau {
  using Row = std::array<double, 16>;

  std::string_view name;  // "5(4)"
  int order;
  int stages;                    // the last at the end of the step
  std::span<const double> time;  // of each stage, in steps
  std::span<const Row> a;        // a row a stage; that of the last are the weights
  Row error;                     // weights less those of the embedded method
  /// Of a second, lower one; zero if there is none. DOP853 stretches: |error| = |e|² / sqrt(|e|² + 0.01 |e_second|²).
  Row second_error;
  /// The stages beyond `stages` serve dense output: coefficients 3 and up of its nested polynomial; empty: none of its
  /// own.
  std::span<const Row> dense;
  double growth, growth_last;  // exponents of the step control: of this error and of the one before
  double stability_limit;      // h |λ| that the method bears, λ real and negative
};

/// Dormand & Prince 5(4) (Hairer, Nørsett & Wanner I, II.5): six evaluations a step.
const RungeKuttaTableau& dormand_prince5();

/// Dormand & Prince 8(5,3), Hairer's DOP853 (ibidem, II.5, II.6): twelve evaluations a step, three more for a dense
/// output of order 7.
const RungeKuttaTableau& dormand_prince8();

}  // namespace lithe
