#pragma once

#include <memory>
#include <optional>
#include <string>

#include "bodies/flexible/body_stress.h"
#include "engine/observe/observer.h"
#include "engine/output/vtu.h"

namespace lithe {

/// What a DeformationWriter adds to the motion of the nodes.
struct DeformationFields {
  bool stress = false, strain = false;
  /// How stresses are recovered; null: by the body's elements (body_stress.h).
  std::shared_ptr<const StressRecovery> recovery{};
};

/// Writes the deformed body at every observed state for ParaView: PATH_0000.vtu ..., and PATH.pvd that lists them with
/// their times. Points are the nodes in world axes. Fields, vectors in world axes: displacement (from the place at the
/// first observed state, m), deformation (relative to the body frame, m), velocity (m/s) and acceleration (m/s²);
/// tensors in the axes of the mesh, which turn with the body frame: stress (Pa) with von_mises, strain (its shear half
/// of the engineering one). Throws FileError if the files cannot be written.
class DeformationWriter final : public Observer {
 public:
  DeformationWriter(const FlexibleBody& body, std::string path_without_extension, const DeformationFields& fields = {});
  void observe(Snapshot& snapshot) override;

 private:
  const FlexibleBody& body_;
  DeformationFields wanted_;
  std::optional<BodyStress> stress_;
  std::vector<VtuCells> cells_;
  Matrix3X start_;  // of the nodes, at the first observed state
  PvdSeries series_;
};

/// The elements of a body as VTU cells.
std::vector<VtuCells> vtu_cells(const ModalBasis& basis);
/// Its undeformed nodes in mesh axes, m.
Matrix3X mesh_nodes(const ModalBasis& basis);

}  // namespace lithe
