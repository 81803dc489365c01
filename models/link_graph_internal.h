#pragma once

#include "models/model_description.h"

namespace lithe {

/// Makes a tree of links and joints whose poses are known, from the root: what a joint ties that is reached already
/// closes a loop; a joint that is reached from its child is turned round, its coordinate unchanged; a link that nothing
/// ties to the root is free. `poses`: of the links in the world.
void make_tree(ModelDescription& model, const std::vector<ModelPose>& poses);

/// The pose of a frame seen from another, both seen from one place.
inline ModelPose seen_from(const ModelPose& from, const ModelPose& frame) {
  return {from.rotation.transpose() * (frame.position - from.position), from.rotation.transpose() * frame.rotation};
}

/// Throws SceneError for one that no real body has, or that is zero where there is mass.
void check_inertia(const ModelLink& link);

}  // namespace lithe
