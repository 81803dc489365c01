#include "bodies/surface_writer.h"

#include "engine/base/error.h"

namespace lithe {

SurfaceWriter::SurfaceWriter(const Body& body, std::string path, Fields fields)
    : body_(body),
      drawable_(dynamic_cast<const DrawableBody*>(&body)),
      fields_(std::move(fields)),
      series_(std::move(path)) {
  if (drawable_) mesh_ = drawable_->drawn_mesh(false);
  if (!mesh_.nodal)
    throw SceneError("'" + body.name() + "' has no surface that it moves itself", body.where(),
                     "a SurfaceWriter is for a Beam or a Cable; for a FlexibleBody take a DeformationWriter");
  VtuCells triangles{"S3", {}};
  for (const auto& t : mesh_.triangles) triangles.connectivity.emplace_back(t.begin(), t.end());
  cells_.push_back(std::move(triangles));
}

void SurfaceWriter::observe(Snapshot& snapshot) {
  const BodyState state = snapshot.body_state(body_);
  Matrix3X points(3, mesh_.points.cols());
  drawable_->drawn_points(state, mesh_, points);
  if (series_.frame_count() == 0) start_ = points;
  std::vector<VtuField> fields = {{"displacement", points - start_}};
  if (fields_)
    for (VtuField& field : fields_(state, mesh_)) fields.push_back(std::move(field));
  series_.add(snapshot.time(), points, cells_, fields);
}

}  // namespace lithe
