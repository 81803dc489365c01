#include "models/link_graph_internal.h"

#include <queue>

#include "engine/base/checks.h"

namespace lithe {

void make_tree(ModelDescription& model, const std::vector<ModelPose>& poses) {
  const std::size_t n = model.links.size();
  std::vector<std::vector<std::size_t>> touching(n);
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    touching[static_cast<std::size_t>(model.joints[j].parent)].push_back(j);
    touching[static_cast<std::size_t>(model.joints[j].child)].push_back(j);
  }
  const std::size_t given = model.joints.size();
  std::vector<bool> reached(n, false), used(given, false);
  const auto spread = [&](int from) {
    std::queue<int> open;
    open.push(from);
    reached[static_cast<std::size_t>(from)] = true;
    for (; !open.empty(); open.pop()) {
      const int link = open.front();
      for (const std::size_t j : touching[static_cast<std::size_t>(link)]) {
        ModelJoint& joint = model.joints[j];
        if (used[j] || joint.closes_loop) continue;
        used[j] = true;
        const int other = joint.parent == link ? joint.child : joint.parent;
        if (reached[static_cast<std::size_t>(other)]) {
          joint.closes_loop = true;
          continue;
        }
        if (joint.child == link) {  // child and parent change places; the axis too, so that the coordinate stays
          std::swap(joint.parent, joint.child);
          std::swap(joint.origin, joint.child_origin);
          if (joint.type == ModelJoint::Type::universal)
            std::swap(joint.axis, joint.second_axis);
          else
            joint.axis = -joint.axis;
        }
        reached[static_cast<std::size_t>(other)] = true;
        open.push(other);
      }
    }
  };
  spread(model.root);
  for (std::size_t i = 0; i < n; ++i)
    if (!reached[i]) {
      ModelJoint free{.name = model.links[i].name + "_free", .type = ModelJoint::Type::floating};
      free.parent = model.root, free.child = static_cast<int>(i);
      free.origin = seen_from(poses[static_cast<std::size_t>(model.root)], poses[i]);
      free.line = model.links[i].line;
      model.joints.push_back(free);
      spread(static_cast<int>(i));
    }
}

void check_inertia(const ModelLink& link) {
  if (link.mass > 0 && !link.inertia.isZero(0)) require::inertia(link.inertia, "the inertia of '" + link.name + "'");
}

}  // namespace lithe
