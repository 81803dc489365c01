#pragma once

#include <memory>

#include "engine/contact/joint_surfaces.h"

namespace lithe {

class Evaluator;
class SystemGraph;

/// Whether joints rub by Coulomb's set-valued law, which time stepping alone knows.
bool has_set_valued_friction(const SystemGraph& graph);

/// Joints whose friction time stepping finds in the evaluator's scene; null: there are none. `left_out` tells its force
/// elements that it does. Throws SceneError for a joint on more than two markers.
std::unique_ptr<JointSurfaces> find_joint_surfaces(Evaluator& evaluator, bool& left_out);

}  // namespace lithe
