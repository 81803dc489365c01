#pragma once

#include <string>

#include "bodies/flexible/flexible_body.h"
#include "engine/observer.h"
#include "engine/output/vtu.h"

namespace lithe {

/// Writes the deformed body at every observed state for ParaView: PATH_0000.vtu ..., and PATH.pvd that lists them with
/// their times. Points are the nodes in world axes; fields: deformation (relative to the body frame, world axes, m),
/// velocity (m/s) and acceleration (m/s²). Throws FileError if the files cannot be written.
class DeformationWriter final : public Observer {
 public:
  DeformationWriter(const FlexibleBody& body, std::string path_without_extension);
  void observe(Snapshot& snapshot) override;

 private:
  const FlexibleBody& body_;
  std::vector<VtuCells> cells_;
  PvdSeries series_;
};

}  // namespace lithe
