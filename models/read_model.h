#pragma once

#include <filesystem>

#include "models/model_description.h"

namespace lithe {

/// Reads a model file, whatever its format. Known: URDF, SDF, MJCF (by the root element), Adams data sets (.adm).
/// Throws FileError for a file that cannot be read, for a format that is not known, and like the reader of the format.
ModelDescription read_model(const std::filesystem::path& path);

/// Reads a URDF (Unified Robot Description Format, ROS): links, joints (revolute, continuous, prismatic, planar,
/// floating, fixed), inertias, damping, mimic, primitive shapes. Limits, dry friction, transmissions, meshes, collision
/// shapes and tags that URDF does not have do not act; the notes list them. Throws FileError, naming file and line, for
/// XML that is not well-formed, numbers that are none or not finite, a link without a name, twice the same name, a
/// joint of unknown type, a parent or child that is no link, an axis without direction, a negative mass, a link that is
/// the child of two joints, links that form a cycle, several roots, and a mimic of nothing or of itself.
ModelDescription read_urdf(const std::filesystem::path& path);

/// Reads an SDF (Simulation Description Format, Gazebo): worlds and models with links, joints (revolute, continuous,
/// prismatic, fixed, ball, universal), frames, inertias, springs and damping, mimic, primitive shapes, closed loops.
/// The root link is "world"; a link that nothing ties to it is free. Throws FileError as read_urdf() does, and for tags
/// that SDF does not have, poses given in a circle, nested models, and joints of other types.
ModelDescription read_sdf(const std::filesystem::path& path);

/// Reads an MJCF (MuJoCo): bodies, joints (hinge, slide, ball, free; several of a body where they are one of the
/// catalogue's), default classes, inertias given or of geoms, springs, damping, armature, equalities (connect, weld,
/// joint), primitive shapes. The root link is "world". Equalities hold exactly. Throws FileError likewise, and for
/// <include> and other tags that stand for more than the file says.
ModelDescription read_mjcf(const std::filesystem::path& path);

/// Reads a data set of Adams/Solver (.adm): PART, MARKER, JOINT, JPRIM, MOTION, SFORCE, VFORCE, VTORQUE, GFORCE,
/// SPRINGDAMPER, BUSHING, BEAM, FIELD, COUPLER, GEAR, GCON, REQUEST, VARIABLE, SPLINE, UNITS, ACCGRAV, INTEGRATOR,
/// SIMULATE, and their functions (models/adams/adams_function.h). Other statements do not act; the notes list them.
/// Without ACCGRAV there is no gravity. Throws FileError, naming file and line, for a data set without UNITS or END, a
/// word that is no statement or argument, identifiers that are used twice or missing, markers, joints, parts and
/// splines that are not there, numbers that are none, an impossible inertia, a part that moves without mass, functions
/// that are cut or read what is unknown, and for user routines, flexible bodies and surfaces, which are not read.
ModelDescription read_adams(const std::filesystem::path& path);

}  // namespace lithe
