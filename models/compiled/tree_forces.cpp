#include <algorithm>

#include "engine/assembly/system.h"
#include "engine/model/input_effort.h"
#include "joints/forces/coordinate_motor.h"
#include "joints/forces/coordinate_spring.h"
#include "models/compiled/tree_maker_internal.h"

namespace lithe {

void CompiledTreeMaker::add_force(const SystemGraph::ForceEntry& entry) {
  if (const auto* spring = dynamic_cast<const CoordinateSpring*>(entry.force)) {
    const auto& p = spring->parameters();
    if (p.law) refuse(*spring, "its law is a function of C++", "give stiffness and damping, or an Input as a motor");
    CompiledTree::Spring compiled = on_joint(*spring, spring->coordinate()[0]);
    compiled.stiffness = number(p.stiffness), compiled.damping = number(p.damping);
    compiled.free_value = number(spring->free_value()), compiled.preload = number(p.preload);
    tree_.springs.push_back(compiled);
  } else if (const auto* motor = dynamic_cast<const CoordinateMotor*>(entry.force)) {
    const auto* effort = motor->parameters().effort.target<InputEffort>();
    if (!effort)
      refuse(*motor, "its effort is a function of C++",
             "give an Input, or none: a compiled scene takes an effort on each joint anyway");
    CompiledTree::Spring compiled = on_joint(*motor, motor->coordinate()[0]);
    compiled.preload = number(*effort->input);
    compiled.sign = -compiled.sign;  // it pushes
    tree_.springs.push_back(compiled);
  } else {
    refuse(*entry.force, "of forces, springs and motors on joint coordinates can be",
           "leave it out, or give its effect as efforts on the joints");
  }
}

CompiledTree::Number CompiledTreeMaker::number(const Adjustable& x) const {
  if (!x.varies()) return {.value = x.at(0)};
  const auto& all = tree_.inputs;
  return {.input = static_cast<int>(std::find(all.begin(), all.end(), x.input()) - all.begin())};
}

CompiledTree::Spring CompiledTreeMaker::on_joint(const Element& element, const JointCoordinate& coordinate) {
  const MarkerKinematics A = now_.marker(coordinate.A), B = now_.marker(coordinate.B);
  const int link_A = places_.at(coordinate.A.body).link, link_B = places_.at(coordinate.B.body).link;
  const auto parallel = [](const auto& a, const auto& b) { return std::abs(std::abs(a.dot(b)) - 1) < 1e-12; };
  const Vector3 axis = A.R.col(coordinate.axis);
  for (const Joint& joint : joints_) {
    const bool same = link_A == joint.link_A && link_B == joint.link_B;
    if (!same && !(link_A == joint.link_B && link_B == joint.link_A)) continue;
    const MarkerKinematics of_A = now_.marker(joint.A), of_B = now_.marker(joint.B);
    for (std::size_t k = 0; k < joint.axes.size(); ++k) {
      const bool turns = joint.axes[k] == 3;
      const Vector3 own = of_A.R.col(turns ? 2 : joint.axes[k]);
      if (!parallel(own, axis)) continue;
      if (turns != (coordinate.kind == JointCoordinate::Kind::angle)) continue;
      if (turns && !(B.R.col(coordinate.axis).dot(axis) > 1 - 1e-12)) continue;
      if (!turns && coordinate.kind != JointCoordinate::Kind::displacement) continue;
      // Across an axis that the joint turns about, only its own markers measure a slide.
      const bool across =
          !turns && joint.axes[k] < 2 && joint.constraint->freedom()->rotation != JointFreedom::Rotation::none;
      if (across && (!same || (B.p - of_B.p).norm() > 1e-14 * scale_)) continue;
      CompiledTree::Spring found;
      found.q = joint.first_q + static_cast<int>(k), found.v = joint.first_v + static_cast<int>(k);
      found.sign = coordinate.sign * (own.dot(axis) > 0 ? 1 : -1) * (same ? 1 : -1);
      const double value =
          coordinate.sign * lithe::measure(coordinate.kind, coordinate.axis, MarkerView(A, 0), MarkerView(B, 1)).value;
      found.offset = snapped(value - found.sign * q_[found.q], std::max(1.0, std::abs(value)));
      return found;
    }
  }
  refuse(element, "its coordinate is not that of one joint", "take the joint's own, as joint.angle()");
}

}  // namespace lithe
