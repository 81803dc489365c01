#pragma once

#include <string>

#include "bodies/flexible/finite_element_model.h"

namespace lithe {

/// A finite-element model from what CalculiX 2.20 writes for `*FREQUENCY, SOLVER=MATRIXSTORAGE` on the free body:
///   job.inp  deck: nodes, node sets, elements       job.dof  node.direction of each matrix row
///   job.sti, job.mas  stiffness (N/m) and mass (kg): `row column value`, one triangle, counted from 1
/// `job` is the path without extension, or any of the four files.
/// Incompatible-mode elements (C3D8I) append nine rows each for "nodes" that no *NODE defines: K is condensed onto the
/// real nodes (exactly, since these modes carry no inertia of their own), M is the nodal block of .mas, which is the
/// consistent mass of C3D8. Not Guyan on M: CalculiX gives the appended rows a mass that is not the body's.
/// Rows are placed by .dof. Nodes that no element uses and no row mentions are left out, with a warning.
/// Throws FileError naming file:line, what was read and how to fix it.
FiniteElementModel read_calculix(const std::string& job);

}  // namespace lithe
