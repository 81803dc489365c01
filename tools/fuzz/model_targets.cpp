// Models of other programs: what is accepted fits together, has finite numbers, and its functions can be evaluated.
#include <cmath>

#include "models/adams/function_value_internal.h"
#include "models/read_model.h"
#include "tools/fuzz/targets.h"

namespace lithe::fuzz {
namespace {

struct AnyTime {
  double time() const { return 0.5; }
  double measure(int) const { return 0.25; }
};

void check(const ModelDescription& model) {
  const int links = static_cast<int>(model.links.size()), joints = static_cast<int>(model.joints.size());
  const auto is_link = [&](int i) { return i >= 0 && i < links; };
  demand(is_link(model.root), "the root is no link");
  std::vector<int> parents(model.links.size(), 0);
  for (const ModelLink& link : model.links) {
    demand(std::isfinite(link.mass) && link.mass >= 0, "a mass is not finite or negative");
    demand(link.inertia.allFinite() && link.inertial.position.allFinite(), "an inertia is not finite");
    demand((link.inertial.rotation.transpose() * link.inertial.rotation - Matrix3::Identity()).norm() < 1e-6,
           "axes of an inertia are no rotation");
  }
  for (const ModelJoint& joint : model.joints) {
    demand(is_link(joint.parent) && is_link(joint.child), "a joint joins what is no link");
    demand(joint.axis.allFinite() && joint.origin.position.allFinite(), "a joint has no place");
    demand(!joint.mimic || (joint.mimic->leader >= 0 && joint.mimic->leader < joints), "a follower has no leader");
    if (!joint.closes_loop && joint.type != ModelJoint::Type::other) ++parents[static_cast<std::size_t>(joint.child)];
  }
  if (!model.adams)
    for (int i = 0; i < links; ++i)
      demand(parents[static_cast<std::size_t>(i)] == (i == model.root ? 0 : 1), "the tree is none");
  demand(!model.sheet().empty() && !model.table().empty(), "there is no sheet");
}

void urdf(std::string_view input, const std::filesystem::path& folder) {
  check(read_urdf(file_of(input, folder, "model.urdf")));
}
void sdf(std::string_view input, const std::filesystem::path& folder) {
  check(read_sdf(file_of(input, folder, "model.sdf")));
}
void mjcf(std::string_view input, const std::filesystem::path& folder) {
  check(read_mjcf(file_of(input, folder, "model.xml")));
}
void adams(std::string_view input, const std::filesystem::path& folder) {
  const ModelDescription model = read_adams(file_of(input, folder, "model.adm"));
  check(model);
  const AnyTime now;
  for (const auto& variable : model.adams->variables) lithe::adams::Value<double, AnyTime>(variable.what, now)();
  for (const auto& motion : model.adams->motions) lithe::adams::Value<double, AnyTime>(motion.what.function, now)();
}

}  // namespace

std::vector<Target> model_targets() { return {{"urdf", urdf}, {"sdf", sdf}, {"mjcf", mjcf}, {"adams", adams}}; }

}  // namespace lithe::fuzz
