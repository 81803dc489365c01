#pragma once

#include <string>
#include <vector>

#include "engine/base/error.h"
#include "engine/gradient/parametric_scene.h"
#include "engine/output/table.h"

namespace lithe {

/// A number that a run, or a scene at rest, comes to. Made by the functions below; `column` is a column of one of the
/// scene's sensors.
struct Quantity {
  enum class Kind { at_time, integral, largest, smallest, at_rest, frequency };
  Kind kind;
  Located column;
  double from = 0, to = 0;   // s; at_time: both the same
  int number = 0;            // of a frequency, from 0
  std::string name() const;  // "tip_z at 1 s", "largest pin_force", "frequency 2"
};

/// The column at a time of the run; between steps by the cubic through four of them.
Quantity value_at(Located column, double time);
/// ∫ column dt over the run, or from one time to another: of the cubics through the steps' ends.
Quantity integral(Located column);
Quantity integral(Located column, double from, double to);
/// The largest and smallest value over the run: of the quartic through the largest of the steps' ends and its four
/// neighbours.
Quantity largest(Located column);
Quantity smallest(Located column);
/// The column in the equilibrium nearest to the drawing (find_equilibrium).
Quantity at_rest(Located column);
/// Hz of an undamped small oscillation about the equilibrium, counted from 0 from the lowest.
Quantity frequency(int number);

struct GradientOptions {
  enum class Mode {
    automatic,  // tangent for no more parameters than quantities, or few; else adjoint
    tangent,    // forwards with the run, a column a parameter
    adjoint,    // backwards over it, a column a quantity
  } mode = Mode::automatic;
  std::size_t memory = std::size_t{512} << 20;  // bytes that the tape may take; beyond, stretches are run again
};

struct Gradient {
  std::vector<std::string> quantities, parameters;
  VectorX values;       // of the quantities
  MatrixX derivatives;  // a row a quantity, a column a parameter

  GradientOptions::Mode mode{};
  long steps = 0;
  double run_seconds = 0;      // CPU of the run alone
  double seconds = 0;          // CPU of all, the run among it
  std::size_t tape_bytes = 0;  // at most
  int stretches = 0;           // of the tape; 1: nothing was run again
  int groups = 0;              // of parameters that are moved together: evaluations a step grow with it
  bool differenced = false;    // elements' tangents were not exact, and columns were differenced instead

  /// Throws SceneError that lists what there is.
  double operator()(const Located& quantity, const Located& parameter) const;
  Table table() const;  // a row a quantity: its number, value, and derivatives by each parameter
};

/// Derivatives of what a scene comes to by its parameters: of the very steps that the scene's integrator takes
/// (GeneralizedAlpha with fixed steps, index 3; ExplicitRungeKutta, Radau, LieBdf; through events; with redundant rows,
/// drives, flexible bodies, beams; with compliant contacts; of MoreauJean with contacts between rigid surfaces), not of
/// the motion that they approximate; and of equilibria and frequencies. The run itself keeps its bits.
///   Tangents of the elements are taken where they are exact, and are differenced where they are not; parameters act
/// through drawings at value ± step (engine/gradient/README.md tells how well, and why so).
/// Throws SceneError for what cannot be differentiated, by name: another integrator, contacts beyond these, a maximum
/// that is reached twice or at an event, in adjoint mode rolling and friction by reactions; SimulationError where the
/// run fails or is not smooth, such as where contacts are about to change.
Gradient gradient(const ParametricScene& scene, const std::vector<Quantity>& quantities,
                  std::vector<DesignParameter> parameters, const GradientOptions& options = {});

}  // namespace lithe
