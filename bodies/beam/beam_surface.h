#pragma once

#include <array>
#include <functional>
#include <vector>

#include "bodies/beam/beam.h"
#include "bodies/beam/section_shape.h"
#include "bodies/flexible/surface_mesh.h"

namespace lithe {

/// Corners (x_2, x_3) of a section, section axes, m: a polygon without holes, counter-clockwise from axis 2 to axis 3.
using SectionOutline = std::vector<std::array<double, 2>>;

/// The boundary of a beam: its section's outline swept along it, closed at both ends, moving with the nodes.
///   const SurfaceMesh skin = surface(beam, SectionShape::rectangle(0.04, 0.02));
///   {skin.frame, shape::surface(skin.nodes, skin.points, skin.triangles)}
/// Flat between its rings of corners: exact on a straight beam, off by κ s²/8 where the axis has the curvature κ and
/// rings are s apart. `rings`: of each element, one or more; one is at a node, those between two nodes cost more to
/// place. SceneError for fewer, for an outline with fewer than three corners, without area, clockwise, or
/// one that crosses itself.
SurfaceMesh surface(Beam& beam, const SectionOutline& outline, int rings = 1);
/// Of round ones a polygon of 32 corners on the rim, flatter than the true one by 0.5 % of its radius at most.
SurfaceMesh surface(Beam& beam, const SectionShape& shape, int rings = 1);
/// Of a section that varies: the outline at each arc length (m), always with the same number of corners.
SurfaceMesh surface(Beam& beam, const std::function<SectionOutline(double arc)>& outline, int rings = 1);

}  // namespace lithe
