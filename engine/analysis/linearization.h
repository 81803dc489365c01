#pragma once

#include <complex>
#include <vector>

#include "engine/analysis/left_out.h"
#include "engine/observe/observer.h"

namespace lithe {

/// The axes in which small motions (ρ, φ, δη) of a body are expressed, v = (u, ω) its velocity in the same axes:
///   body    δp = A ρ, turn φ in body axes:  δu = ρ̇ + ω × ρ + u × φ,  δω = φ̇ + ω × φ
///   world   δp = ρ,   turn φ in world axes: δu = ρ̇,                  δω = φ̇ - ω × φ
/// A motion is steady, and linear equations have constant coefficients, in body axes if the mechanism turns as one
/// (carousel, rotor and all it carries on isotropic bearings), in world axes if bodies of revolution spin and nothing
/// else moves but straight ahead (rotors on any bearing, a bicycle).
enum class PerturbationAxes { body, world };

/// A free small motion of the whole mechanism: q = base ⊕ Re(a shape e^{s t}).
struct Mode {
  std::complex<double> eigenvalue;  // s, 1/s; of a conjugate pair the one with Im s > 0
  Eigen::VectorXcd shape;           // v_count long: (δp world axes, turn in body axes, δη); its largest entry is 1

  double frequency() const { return eigenvalue.imag() / (2 * M_PI); }  // Hz, of the damped oscillation
  double growth() const { return eigenvalue.real(); }                  // 1/s; positive: unstable
  double damping_ratio() const { return std::abs(eigenvalue) > 0 ? -eigenvalue.real() / std::abs(eigenvalue) : 0; }
};

/// Small motions about a state, in minimal coordinates. Positions ζ = Z_p y and velocities ξ = Z_v w + P y span what
/// the rows allow (Z: orthonormal); y and w differ in number where rows restrict velocities alone (rolling).
///   ẏ = B_w w + B_y y,   M₁ ẇ + C₁ w + K₁ y = 0           the general form, E ẋ = A x with x = (y, w)
///   M ÿ + C ẏ + K y = 0                                   if all rows are holonomic, ξ = ζ̇ + transport(ζ)
/// Friction by reactions is taken at the reactions of the base.
/// Gyroscopic, centrifugal and follower terms, the geometric stiffness of loaded joints and moving drives are included:
/// the engine's own residual is differenced. If the motion is not steady in the chosen axes, the coefficients are
/// those of the instant.
struct Linearization {
  State state;              // the base, with consistent accelerations and multipliers
  MatrixX position_basis;   // Z_p, in the axes of the perturbation
  MatrixX velocity_basis;   // Z_v
  MatrixX E, A;             // of the first-order form
  MatrixX M, C, K;          // of the second-order form; empty with nonholonomic rows
  VectorX undamped;         // ω² of (K + Kᵀ)/2 and M, ascending, 1/s²; negative: an unstable stiffness
  std::vector<Mode> modes;  // by frequency, those that do not oscillate first
  std::vector<DeflectionLeftOut> left_out;  // of the base: an estimate of what its bodies' modes leave out
  double frequency_left_out = 0;            // relative error of the lowest stable frequency by these modes, an estimate
  double unsteadiness = 0;  // 1/s: how fast Z turns among the coordinates; 0 at rest and in relative equilibria

  /// Hz of the undamped modes, 0 for those without positive stiffness.
  VectorX undamped_frequencies() const;
  /// Smallest ω²: a static equilibrium is stable if it is positive.
  double lowest_stiffness() const { return undamped.size() > 0 ? undamped[0] : 0; }
  /// Largest Re s.
  double largest_growth() const;
};

struct LinearizeOptions {
  PerturbationAxes axes = PerturbationAxes::body;
  int mode_count = 0;  // eigenvalues from so many undamped modes, lowest first (holonomic rows); 0: from all
  double step = 1e-3;  // of the differences, of the bodies' size: there truncation and round-off balance for smooth
                       // forces; smaller where forces change over micrometres (bearings): 1e-6
};

/// Linearizes about `state` (positions and velocities that satisfy the rows). M, C, K have some ten digits:
/// fourth-order differences. Dense: for up to some thousand velocities.
/// Modes that bodies have and do not use are estimated (engine/analysis/left_out.h), and reported above kLeftOutToTell.
/// Throws SceneError for a state of another system, one off its constraints, and a step that is not positive.
Linearization linearize(const System& system, const State& state, const LinearizeOptions& options = {});

/// The base displaced along a mode: by Re(amplitude shape e^{i phase}), moving with the velocity of the mode.
/// Amplitude: of the largest entry of the shape (m, rad or the unit of η). Then moved onto the constraints.
State displaced(const System& system, const Linearization& about, const Mode& mode, double amplitude, double phase);

/// Gives an observer `frames` states over one period of a mode, at times 0 … 1/frequency (a mode that does not
/// oscillate: there and back in one second), for recorders and writers of pictures.
void animate(const System& system, const Linearization& about, const Mode& mode, double amplitude, int frames,
             Observer& observer);

}  // namespace lithe
