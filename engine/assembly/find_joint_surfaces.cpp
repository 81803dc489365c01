#include "engine/assembly/find_joint_surfaces.h"

#include <algorithm>
#include <optional>

#include "engine/assembly/evaluated.h"
#include "engine/assembly/least_norm.h"

namespace lithe {
namespace {

class EvaluatedSurfaces final : public JointSurfaces {
 public:
  EvaluatedSurfaces(Evaluator& evaluator, Scene scene, std::vector<Surface> surfaces)
      : JointSurfaces(std::move(scene), std::move(surfaces)), evaluator_(evaluator) {}

  void felt(MatrixRef lambda) override {
    if (evaluator_.redundant_rows().empty()) return;
    if (!least_norm_) least_norm_.emplace(evaluator_.system().blocks());
    least_norm_->forget();
    for (int k = 0; k < lambda.cols(); ++k)
      lambda.col(k) = least_norm_->of(evaluator_.workspace().values, lambda.col(k));
  }

 private:
  Evaluator& evaluator_;
  std::optional<LeastNorm> least_norm_;
};

}  // namespace

bool has_set_valued_friction(const SystemGraph& graph) {
  return std::ranges::any_of(graph.forces(), [](const auto& entry) {
    const auto* friction = dynamic_cast<const FrictionByImpulses*>(entry.force);
    return friction && friction->is_set_valued();
  });
}

std::unique_ptr<JointSurfaces> find_joint_surfaces(Evaluator& evaluator, bool& left_out) {
  const System& system = evaluator.system();
  const SystemGraph& graph = system.graph();
  std::vector<JointSurfaces::Surface> surfaces;
  int row = 0, first = 0;
  for (const auto& entry : graph.forces()) {
    const int at = row, count = entry.force->row_count();
    row += count;
    const auto* friction = dynamic_cast<const FrictionByImpulses*>(entry.force);
    if (!friction) continue;
    const Constraint& joint = friction->pressed_by();
    const auto* joint_entry = &graph.constraints().front();  // assemble() has seen that it is of this graph
    while (joint_entry->constraint != &joint) ++joint_entry;
    if (joint.marker_count() != 2)
      throw SceneError(
          "'" + entry.force->name() + "' rubs in a joint of " + std::to_string(joint.marker_count()) + " markers",
          entry.force->where(), "name a joint between two markers");
    const double* turns =
        joint.angles().empty() ? nullptr : evaluator.workspace().quarter_turns.data() + system.first_angle(joint);
    surfaces.push_back({friction, &joint, entry.markers, joint_entry->markers, turns, system.rows(joint).first, at,
                        first, count,
                        friction->is_set_valued() ? system.layout().slice(*entry.markers.back().body).v : -1});
    first += count;
  }
  if (surfaces.empty()) return nullptr;
  const auto motion_of = [&evaluator](const Marker& m) { return marker_kinematics(evaluator, m, Level::velocity); };
  const Workspace& work = evaluator.workspace();
  return std::make_unique<EvaluatedSurfaces>(
      evaluator,
      JointSurfaces::Scene{system.blocks(), work.values, system.layout().row_count(), row, work.time, motion_of,
                           left_out},
      std::move(surfaces));
}

}  // namespace lithe
