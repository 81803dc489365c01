#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "bodies/flexible/finite_element_model.h"
#include "bodies/flexible/modal_basis.h"

namespace lithe {

/// Information that a file does not contain.
struct ImportOptions {
  /// "mm-t-s" and the like (readers/unit_system.h). Empty: SI, if density and wave speed are those of a real material;
  /// otherwise the error lists what each system would mean.
  std::string units{};
  /// For meshes without matrices (gmsh), in the units of the mesh: by name of physical volume, "" for all others.
  std::map<std::string, Material> materials{};
  int frequencies = 10;  // elastic ones of the free body, computed for the sheet
};

/// A flexible body read from a file, in SI units, with checks of what was read.
struct FlexibleBodyFile {
  std::string format;                               // "CalculiX matrices"
  std::vector<std::string> files;                   // all that were read
  std::string units;                                // units of the file: "mm-t-s (N, MPa): density 7850 kg/m3, ..."
  std::shared_ptr<const FiniteElementModel> model;  // null for a body that came reduced
  std::shared_ptr<const ModalBasis> basis;          // of a body that came reduced, else null
  MatrixX modes;                                    // dofs x k, that came along (.frd), else empty
  ModelCheck check;
  VectorX frequencies;             // Hz, free, without the six rigid motions
  std::vector<std::string> notes;  // order of rows, triangles, what was condensed, converted or left out
  std::string sheet() const;       // all of it, for a reader
};

/// Reads a flexible body of any known format, recognised by content, with the files that stand beside it:
///   CalculiX        job.inp, job.sti, job.mas, job.dof; mode shapes of job.frd if there (name any of them, or "job")
///   Matrix Market   K.mtx, M.mtx, nodes.csv, perhaps node_sets.csv, elements.csv (name K.mtx or the folder)
///   Abaqus          job.inp, job_STIF1.mtx, job_MASS1.mtx (name any)
///   ANSYS           stiffness and mass, K and M in their names, as HBMAT or MMF; K.mapping or the only one, the only
///                   .cdb, .node or .lis of the folder (name either matrix)
///   Nastran         .bdf, .dat with DMIG, or with .pch or .op4 of its name, rows of .op4 in .rows (name any; a deck
///                   under another name is found if it is the only one)
///   SID             one file, reduced already
///   gmsh            .msh 2.2 or 4.1 with materials from the options
/// Units become SI, and require_sound() checks the model. Throws FileError naming file:line, or SceneError.
FlexibleBodyFile read_flexible_body(const std::string& path, const ImportOptions& options = {});

}  // namespace lithe
