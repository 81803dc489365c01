#pragma once

#include <memory>

#include "engine/contact/joint_surfaces.h"

namespace lithe {

class Evaluator;

/// Joints with set-valued friction in the evaluator's scene; null: there are none. Throws SceneError for a joint on
/// more than two markers.
std::unique_ptr<JointSurfaces> find_joint_surfaces(Evaluator& evaluator);

}  // namespace lithe
