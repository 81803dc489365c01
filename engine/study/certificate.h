#pragma once

#include <string>
#include <vector>

#include "engine/model/deformable_body.h"
#include "engine/output/chart.h"

namespace lithe {

/// The parts of a stated error, in the unit of the quantity; none is negative.
struct StatedError {
  double truncation = 0;  // modes that are left out
  double deflection = 0;  // what the model leaves out of the second order: stiffening, large deflection
  double time = 0;        // of the integrator
  double solver = 0;      // constraints not met
  double mesh = 0;        // elements of bodies that can be drawn with more
  double total() const { return truncation + deflection + time + solver + mesh; }
};

/// What is known of one wanted quantity.
struct CertifiedQuantity {
  std::string name;
  double change = 0;  // largest change in the run, max |y(t) - y(0)|
  double bound = 0;   // the error that was asked for, in the quantity's unit
  StatedError error;
  bool met() const { return error.total() <= bound; }  // not, if either is not finite
};

/// One candidate mode of a body, and what it does.
struct ModeEffect {
  int mode = 0;          // from 0
  double frequency = 0;  // Hz
  bool used = false;
  std::vector<double> effect;  // on each wanted quantity, in its unit: the largest over the run
};

/// The model that a deformable body got.
struct ChosenBody {
  std::string name;
  Fidelity fidelity;
  Deflection finest = Deflection::linear;  // that its basis has data for
  std::vector<ModeEffect> modes;           // all candidates
  /// What the second order does to each quantity, however many modes there are; empty: not to be told without data.
  std::vector<double> deflection_effect;
  std::string why;   // in words
  int elements = 0;  // of its mesh; 0: the body has one mesh only
};

/// A model and its error, run or estimated.
struct CertificateTrial {
  std::string model;     // "rigid", "3 of 20 modes, stiffened"
  double tolerance = 0;  // of the integrator; 0: not run
  bool run = false;      // else its error and cost are estimated
  double error = 0;      // stated, the largest over the quantities in parts of their bounds
  double cost = 0;       // s of CPU
};

/// Where the time of choosing went: runs of one kind, the one that gave the answer among them.
struct CertificateCost {
  std::string what;  // "modes, fixed steps"
  int runs = 0;
  long steps = 0;   // of all of them; 0: no steps were taken
  double cost = 0;  // s of CPU
};

std::string to_string(Deflection deflection);
/// A fidelity in words, of so many candidate modes: "rigid", "3 of 20 modes, stiffened", "40 exact elements".
std::string model_text(const Fidelity& fidelity, int candidates);

/// The certificate of an answer: which model, which integrator, which step, and how large the remaining error is.
struct Certificate {
  std::string scene;
  double duration = 0;                      // s
  std::vector<std::string> simplification;  // of the graph, a line each
  std::vector<ChosenBody> bodies;
  std::string integrator;
  double tolerance = 0;
  long steps = 0;
  double mean_step = 0;  // s
  std::vector<CertifiedQuantity> quantities;
  std::vector<CertificateTrial> trials;  // in the order they were considered
  int chosen = -1;                       // of the trials
  double cost = 0;                       // s of CPU, choosing included
  double answer_cost = 0;                // s of CPU of the run that gave the answer
  std::vector<CertificateCost> costs;    // what `cost` went into; the rest is set-up and comparison
  std::vector<std::string> remarks;      // what a reader must know: what no model at hand reaches, and why

  /// Every quantity's stated error is within what was asked; false if nothing was asked.
  bool met() const;
  /// The sheet, for a fixed-width font of 100 columns; three digits.
  std::string text() const;
  /// The members by their names, with units; what is not finite is null. Effects are in the order of "quantities".
  /// Throws FileError.
  void write_json(const std::string& path) const;
  /// Error in parts of what was asked for over cost, the trials that ran and those that were estimated; the chosen one
  /// marked, and a line at 1. Points without a cost, or whose error is 0 or infinite, are left out; without lines if no
  /// point is left.
  Chart chart() const;
};

}  // namespace lithe
