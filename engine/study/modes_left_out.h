#pragma once

#include <string>
#include <vector>

#include "engine/analysis/equilibrium.h"
#include "engine/model/system_graph.h"

namespace lithe {

/// What the modes that a scene uses leave out of a static answer: its equilibrium, and the stiffness and frequencies of
/// small motions about it, beside those with all candidate modes of its deformable bodies. The way to know it:
///   .basis = make_basis(model, frame, 24), .mode_count = 8
/// A body that uses all of its candidates has nothing to compare with, and says so.
struct ModesLeftOut {
  using Body = DeflectionLeftOut;
  std::vector<Body> bodies;
  double lowest_stiffness = 0, richer_stiffness = 0;  // lowest ω² with the modes in use, with all candidates, 1/s²
  double frequency_error = 0;  // of the lowest frequency that both have, relative; where either is unstable, 1
  Equilibrium richer;          // with all candidates, of another system: of the graph with these

  /// Largest part of a body's deflection that is missing, or error of the lowest frequency.
  double largest() const;
  /// One line a body, one of the stiffness.
  std::string text() const;
};

/// Finds the equilibrium near that of `system`, assembled from `graph`, once more with all candidate modes, and
/// linearizes about both. Warns through the log where more than `fraction` is missing, and of bodies that have no
/// candidates beyond those in use. The graph has its models again afterwards; systems assembled before, `system` too,
/// must not be used any more. Costs an equilibrium and a linearization with all candidates.
/// Throws as find_equilibrium() and linearize() do.
ModesLeftOut find_modes_left_out(SystemGraph& graph, const System& system, const Equilibrium& found,
                                 double fraction = 0.05, const EquilibriumOptions& options = {});

}  // namespace lithe
