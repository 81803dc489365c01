#pragma once

#include <vector>

#include "engine/model/contact_point.h"
#include "joints/contact/shape_internal.h"

/// Contact of surfaces made of triangles. One-sided: their outside is where they are counter-clockwise. Exact for what
/// is flat or round: faces, edges and corners as they are, and no contact with an edge across which the surface goes
/// on.
namespace lithe::narrow {

/// A static mesh or height field (A) with a convex shape: touches with gap < reach, appended; world axes.
///   sphere, capsule   where the surface is nearest to the centre, or the ends and the inside of the axis
///   box, hull         corners over triangles, edges across open edges, and corners of the mesh against faces
///   cylinder, cone    the lowest point and eight more around the face or line that faces a triangle; open edges by GJK
/// What is below the surface is pushed out to the nearest triangle, as long as part of it is above.
void mesh_convex(const Shape::Data& mesh, const btTransform& at, const btConvexShape& b, const btTransform& bt,
                 double reach, std::vector<Touch>& touches);

/// Two static meshes or height fields: corners of either that stand out over triangles of the other, and open edges
/// that cross. Pushed out from no deeper than half the thickness of the thinner one.
void mesh_mesh(const Shape::Data& a, const btTransform& at, const Shape::Data& b, const btTransform& bt, double reach,
               std::vector<Touch>& touches);

/// A half space (A: z <= 0 of its transform) with the corners of a mesh or height field.
void mesh_plane(const btTransform& plane, const Shape::Data& mesh, const btTransform& at, double reach,
                std::vector<Touch>& touches);

/// The deforming boundary of a body with any other collider but a compound (with its parts, then); appended. Normal out
/// of the collider of smaller number.
///   half space          every node
///   convex              as mesh_convex with the deformed triangles, and every node against the shape
///   mesh, height field  nodes against triangles, and corners of the mesh that stand out against deformed triangles
///   surface             nodes of either against triangles of the other
/// With the last two also edges that stand out across each other.
/// Looks only at the nodes that may be near by what η can have moved (Shape::Data::reach); at all where that is not
/// known.
void surface_contacts(const ContactPoses& poses, int surface_collider, const Shape::Data& surface, int other_collider,
                      const Shape::Data& other, double reach, std::vector<ContactPoint>& points);

}  // namespace lithe::narrow
