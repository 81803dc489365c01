#pragma once

#include <string>

#include "bodies/beam/beam.h"

namespace lithe {

/// Pose of the blade of a table, and data that the table may not contain.
struct BeamTablePlace {
  FramePose root{};   // of the blade frame: origin and axes x flapwise, y edgewise, z along the blade; world axes
  double length = 0;  // m, of the straight axis of a BeamDyn blade file that is read without its primary input
};

/// Axis, sections and damping of a beam from a file; set .elements and .stations of what it returns:
///   Beam::Parameters table = beam_table("blade.csv");
///   table.elements = 40;
///   auto& blade = graph.add<Beam>("blade", table);
/// The axis is the natural cubic spline of x, y and twist over z. A section has axis 1 along it, axes 2 and 3 are x and
/// y of the blade, turned about z by MINUS the twist. Sections are linear between their stations, in section axes.
///
/// A name that ends in .csv: a line of names, then a line for each station; SI units, order 1, 2, 3 of the section:
///   z [x y], or arc  m; arc stands for a straight axis         twist           degrees, 0 if not given
///   C11 … C66        stiffness, upper triangle or all of it    EA GA2 GA3 GJ EI2 EI3  its diagonal
///   M11 … M66        mass, the same                            mass, J1 J2 J3         its diagonal
///   damping          s, of all strains                         damping1 … damping6    s, one a strain
/// Diagonals are required, other entries are zero if not given. Lines that start with # are comments.
///
/// Any other name: a BeamDyn primary input (key points, BldFile) or a BeamDyn blade file; damp_type 0 or 1.
/// Format: BeamDyn user's guide, OpenFAST documentation.
///
/// Throws FileError, with file and line, for input that it cannot read; SceneError for stations out of order and for a
/// section that BeamSection::check refuses.
Beam::Parameters beam_table(const std::string& path, const BeamTablePlace& place = {});

}  // namespace lithe
