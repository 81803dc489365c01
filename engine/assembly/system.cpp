#include "engine/assembly/system.h"

#include <algorithm>
#include <functional>

#include "engine/base/error.h"

namespace lithe {

const Layout::RowSlice& System::rows(const Constraint& constraint) const {
  const auto& ours = graph_->constraints();
  for (std::size_t i = 0; i < layout_.rows().size(); ++i)
    if (ours[i].constraint == &constraint) return layout_.rows()[i];
  throw SceneError("constraint '" + constraint.name() + "' is not in this system", constraint.where(),
                   "use a joint of the graph that was assembled, added before assemble()");
}

bool System::may_leave_out(const std::vector<int>& rows) const {
  if (rows.empty()) return true;
  return rows.size() == redundant_.size() && rows.front() >= 0 && rows.back() < layout_.row_count() &&
         std::is_sorted(rows.begin(), rows.end(), std::less_equal<>());
}

int System::find_angle(const JointCoordinate& x) const {
  for (std::size_t i = 0; i < angles_.size(); ++i) {
    const Angle& a = angles_[i];
    if (a.of_A == x.A && a.of_B == x.B && a.axis == x.axis && a.to_point == (x.kind == JointCoordinate::Kind::bearing))
      return static_cast<int>(i);
  }
  return -1;
}

int System::first_angle(const Connector& connector) const {
  const auto& joints = graph_->constraints();
  const auto& forces = graph_->forces();
  std::size_t i = 0;
  while (i < joints.size() && joints[i].constraint != &connector) ++i;
  if (i == joints.size())
    while (i - joints.size() < forces.size() && forces[i - joints.size()].force != &connector) ++i;
  return first_angles_.at(i);
}

}  // namespace lithe
