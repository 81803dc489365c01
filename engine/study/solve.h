#pragma once

#include <string>
#include <vector>

#include "engine/model/deformable_body.h"
#include "engine/motion/make_integrator.h"
#include "engine/observe/sensors.h"
#include "engine/output/table.h"
#include "engine/study/certificate.h"

namespace lithe {

/// How well a quantity is wanted: the largest error over the sampled instants, the Euclidean norm over its columns.
struct Precision {
  double value = 0.01;
  bool relative = true;  // to the largest change of the quantity in the run, max |y(t) - y(0)|; else in its unit
};
/// Throws SceneError unless the value is positive and finite.
Precision percent(double value, std::source_location where = std::source_location::current());
Precision within(double bound, std::source_location where = std::source_location::current());

struct Want {
  Sensor sensor;
  Precision precision;
};
inline Want want(Sensor sensor, Precision precision) { return {std::move(sensor), precision}; }

/// The integrators that solve() works with.
struct SolveMethods {
  MakeIntegratorBy<Tolerance> by_tolerance;
  /// Of second order in its fixed step, s, at home with stiff modes. None: by tolerance alone.
  MakeIntegratorBy<double> by_step;
  /// The same for scenes whose surfaces are rigid. None: these are refused.
  MakeIntegratorBy<double> by_step_with_impacts;
};

struct SolveOptions {
  int samples = 100;            // instants after the first, evenly spaced
  std::string scene = "scene";  // its name on the sheet
  /// The graph first: welded bodies, planar motion, islands (engine/simplify/simplification.h). The answer is the same.
  bool simplify = true;
  /// Deflections are known to be small: their second order stays out of the statement where a basis has no data for it.
  /// Else nothing is certified with such a basis.
  bool small_deflection = false;
  int most_runs = 4;  // of models that deform, before the precision is reported as not reached
};

/// The answer and its certificate. The graph is left with the chosen models: assemble(graph) uses them.
struct Solution {
  Table samples;  // "t", then the columns of the wanted quantities
  Certificate certificate;
};

/// Runs a scene with the smallest model that gives the wanted quantities as well as they are wanted, and states how
/// large the error that remains is.
///   1. A run with rigid bodies. Its accelerations, spins and reactions drive every candidate mode of every body
///      (model_error.h); what the modes do to the motion at large is found by a second rigid run under these loads.
///   2. Rigid bodies do if all of deformation does little. Otherwise modes stay out as long as their effects together
///      are a small part of what is allowed.
///   3. The model so chosen runs beside a richer one (more modes, the finest order of deflection), both in the same
///      steps: their difference is what it leaves out. It gets more modes, or the next order, until that is allowed.
///   4. Finer steps, or a tolerance, until what they leave over is allowed too, by the differences of the runs.
///   5. Bodies that can be drawn with any number of elements (bodies/beam/slender_body.h) run with half as many too,
///      which tells their part of the error; where modes do not suffice, they are exact, with more elements until it is
///      met.
/// Bodies without candidates stay as they are drawn. integrators/solve.h has the default methods.
/// Contacts: errors of steps are taken to be of first order across compliant ones. Where surfaces are rigid, models
/// with a quarter, half and all of the candidate modes are compared, and steps by halving them (remarks say what is not
/// known). Throws SceneError for no or invalid wants, a duration that is not positive, rigid surfaces without a method
/// for them, and whatever drawing throws; SimulationError if no model reaches the end.
Solution solve(SystemGraph& graph, double duration, const std::vector<Want>& wants, const SolveMethods& methods,
               const SolveOptions& options = {});

}  // namespace lithe
