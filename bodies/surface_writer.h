#pragma once

#include <functional>
#include <string>
#include <vector>

#include "engine/model/appearance.h"
#include "engine/observe/observer.h"
#include "engine/output/vtu.h"

namespace lithe {

class Beam;

/// Writes the drawn surface of a slender body (Beam, Cable) at every observed state for ParaView: PATH_0000.vtu …, and
/// PATH.pvd that lists them with their times. Points: nodes on the axis, then the surface, world axes. Fields:
/// displacement (from the place at the first observed state, m, world axes) and those of `fields`.
///   SurfaceWriter writer(blade, "blade", section_fields(blade));
///   simulation.observe(writer, every(0.01));
/// For a FlexibleBody: DeformationWriter. Throws SceneError for a body that has no such surface, FileError if the files
/// cannot be written.
class SurfaceWriter final : public Observer {
 public:
  using Fields = std::function<std::vector<VtuField>(const BodyState& state, const DrawnMesh& mesh)>;
  SurfaceWriter(const Body& body, std::string path_without_extension, Fields fields = {});
  void observe(Snapshot& snapshot) override;

 private:
  const Body& body_;
  const DrawableBody* drawable_;
  Fields fields_;
  DrawnMesh mesh_;
  std::vector<VtuCells> cells_;
  Matrix3X start_;  // of the points, at the first observed state
  PvdSeries series_;
};

/// Of a beam, in section axes (1 along it): strain (Γ, –) and curvature (K, 1/m), force (n, N) and moment (m, N m); at
/// a node the mean of its two elements. The beam must outlive the writer.
SurfaceWriter::Fields section_fields(const Beam& beam);

}  // namespace lithe
