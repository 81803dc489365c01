#pragma once

#include <complex>
#include <string>
#include <vector>

#include "engine/analysis/linearization.h"
#include "engine/model/input.h"
#include "engine/observe/sensors.h"

namespace lithe {

using Complex = std::complex<double>;

/// A transfer function from one input to one output: H(s) = gain Π (s - zeros) / Π (s - poles). Poles and zeros that
/// meet are kept: what cannot be excited or seen has both.
struct TransferFunction {
  std::string input, output;
  std::vector<Complex> poles, zeros;  // 1/s; by magnitude
  double gain = 0;                    // real: of the leading terms

  Complex operator()(Complex s) const;
};

/// How small changes of inputs u move a mechanism, and what small changes of outputs y come of it:
///   ẋ = A x + B u + B₁ u̇ + B₂ ü,   y = C x + D u + D₁ u̇ + D₂ ü
/// in minimal coordinates x = (y, w), the positions and velocities that the rows allow (Linearization). B₁, B₂, D₁, D₂
/// are not zero only where an input prescribes a motion (a drive) or a law takes its rate (the target of a PID
/// controller). The same with all coordinates, as a descriptor system
///   E ẋ = A x + B u,   y = C x + D u,   x = (ζ, ξ, λ, u*)
/// of positions and velocities of all bodies in the axes of the linearization, multipliers of the rows that are
/// independent, and of each input whose rates act those, u* = (u, u̇, ü).
/// Friction by reactions is taken at the reactions of the base; contacts as they are there.
struct StateSpace {
  Linearization about;
  std::vector<std::string> inputs, outputs;            // names; outputs: the columns of the sensors
  std::vector<std::string> input_units, output_units;  // empty: not known, or none
  MatrixX A, B, C, D;
  MatrixX B_rate, B_acceleration, D_rate, D_acceleration;  // B₁, B₂, D₁, D₂
  struct Descriptor {
    MatrixX E, A, B, C, D;
    std::vector<std::string> states;  // "link: omega_y", "... rate of ...", "lambda of pin row 1"
  } descriptor;

  /// H(s), outputs by inputs. On the imaginary axis, s = 2πi f, it is the frequency response.
  Eigen::MatrixXcd response(Complex s) const;
  /// The same by the descriptor system: a check.
  Eigen::MatrixXcd descriptor_response(Complex s) const;
  /// Eigenvalues of A, 1/s, by magnitude.
  std::vector<Complex> poles() const;
  /// Of one input and one output: the finite s in which H(s) vanishes. Throws SceneError for numbers that do not exist.
  std::vector<Complex> zeros(int input, int output) const;
  TransferFunction transfer_function(int input, int output) const;
};

/// Linearizes about `state` with these inputs and outputs. The sensors may be of any kind: positions, accelerations,
/// reactions, energies. Derivatives are central differences of fourth order of the engine's own residual and of the
/// sensors, as those of linearize(system, state). An input is moved by a thousandth of its range, or of its size where
/// it has no bounds. Throws SceneError as that does, for no input or output, and for inputs that are not of the
/// system's graph.
StateSpace linearize(const System& system, const State& state, const std::vector<const Input*>& inputs,
                     const std::vector<Sensor>& outputs, const LinearizeOptions& options = {});

// ---- frequency response ----

/// Of one input and one output at frequencies f (Hz).
struct FrequencyResponse {
  std::string title;
  std::vector<double> frequency;
  std::vector<Complex> value;

  std::vector<double> decibels() const;
  /// Degrees, without jumps of a turn from point to point.
  std::vector<double> phase() const;
};

/// `count` frequencies from `from` to `to` (Hz), evenly spaced by their logarithm, and more about lightly damped poles,
/// whose peaks would fall between them. Throws SceneError unless 0 < from < to and count >= 2.
FrequencyResponse frequency_response(const StateSpace& system, int input, int output, double from, double to,
                                     int count = 400);

/// Amplitude (dB) and phase (degrees) over frequency: path_amplitude.svg, .png and path_phase.svg, .png; as
/// write_chart().
void write_bode(const std::vector<FrequencyResponse>& responses, const std::string& path_without_extension);
/// The imaginary part over the real part.
void write_nyquist(const std::vector<FrequencyResponse>& responses, const std::string& path_without_extension);

// ---- files ----

/// path_A.csv and so on, a file a matrix; columns are named after states and inputs. The minimal form, then the
/// descriptor's as path_descriptor_E.csv and so on. FileError if one cannot be written.
void write_csv(const StateSpace& system, const std::string& path_without_extension);
/// One file: /A … /D, /B_rate … of the minimal form, /descriptor/E …, names and units as texts, units as attributes.
void write_hdf5(const StateSpace& system, const std::string& path);
/// path_A.mtx and so on, as coordinates (descriptor) or as arrays (minimal form).
void write_matrix_market(const StateSpace& system, const std::string& path_without_extension);

}  // namespace lithe
