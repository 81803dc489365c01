// Contacts of bodies that joints and drives hold completely, so that no impulse can move them.
#include <cmath>

#include "engine/base/error.h"
#include "engine/base/number_text.h"
#include "engine/contact/rigid_contacts.h"
#include "engine/motion/equations_of_motion.h"

namespace lithe {
/// Of the body by itself, along the normal, without its turning: by the diagonal of its block of S where that has more,
/// which is at least as stiff; 0 where the block tells nothing of it.
double RigidContacts::mobility_alone(const ContactRows::Side& side, int rows) const {
  const BlockStructure& blocks = scene_.blocks;
  const auto frame = std::ranges::find(blocks.frames, side.velocity, &BlockStructure::Frame::v);
  if (frame != blocks.frames.end())
    return 3 / Eigen::Map<const Matrix6>(scene_.values.data() + frame->values).topLeftCorner<3, 3>().trace();
  const auto linear = std::ranges::find(blocks.linears, side.velocity, &BlockStructure::Linear::v);
  if (linear == blocks.linears.end() || side.count > linear->size) return 0;
  const std::vector<int>& diagonal = diagonals_[static_cast<std::size_t>(linear - blocks.linears.begin())];
  double sum = 0;
  for (int k = 0; k < side.count; ++k) {
    const double h = rows_.values(side)[rows * k];
    const int at = linear->pattern ? diagonal[static_cast<std::size_t>(k)] : linear->values + k;
    sum += h * h / scene_.values[static_cast<std::size_t>(at)];
  }
  return sum;
}

bool RigidContacts::is_held(int point) const {
  constexpr double kMoves = 1e-10;  // of the mobility of the bodies alone: round-off of what joints take away
  const ConeProblem::Contact& contact = problem_.contacts[static_cast<std::size_t>(point)];
  const ContactRows::Row& row = rows_.points()[static_cast<std::size_t>(point)];
  double mobility = 0, alone = 0;
  for (int s = 0; s < 2; ++s) {
    const ConeProblem::Side& side = contact.sides[s];
    if (side.group < 0) continue;
    if (components_[static_cast<std::size_t>(used_[static_cast<std::size_t>(side.group)])].alone) return false;
    for (int k = 0; k < side.count; ++k)
      mobility += problem_.values[static_cast<std::size_t>(side.H + contact.rows * k)] *
                  problem_.values[static_cast<std::size_t>(side.Y + side.first + k)];
    alone += mobility_alone(row.sides[s], row.rows);
  }
  return alone > 0 && std::abs(mobility) <= kMoves * alone;
}

void RigidContacts::refuse_held(int point, const State& start, double speed) {
  constexpr double kHolds = 1e-6;  // of the largest reaction to a push along the normal
  constexpr double kLight = 3e8;   // m/s
  EquationsOfMotion& equations = scene_.equations;
  const Layout& layout = equations.layout();
  const ContactRows::Row& row = rows_.points()[static_cast<std::size_t>(point)];
  const ContactElement& contact =
      *scene_
           .records[static_cast<std::size_t>(
               pairs_[static_cast<std::size_t>(points_[static_cast<std::size_t>(point)].pair)].element)]
           .element;
  // 0. Round-off of such numbers tells nothing of what holds a body.
  if (!(speed < kLight)) {
    Eigen::Index fastest = 0;
    start.v.cwiseAbs().maxCoeff(&fastest);
    throw SimulationError("the motion has left all bounds: surfaces of '" + contact.name() + "' meet at " +
                              three_digits(speed) + " m/s" + "; the largest velocity is " +
                              layout.velocity_name(static_cast<int>(fastest)),
                          contact.where() + ", " + time_text(start.time),
                          "look for what drives it before: a force that feeds energy in, a step that is too long for a "
                          "stiff one");
  }
  // 1. What takes up a push, and of that what prescribes motion.
  std::string bodies;
  VectorX reactions = VectorX::Zero(layout.row_count()), rate = reactions;
  for (const ContactRows::Side& side : row.sides) {
    if (side.count == 0) continue;
    bodies += (bodies.empty() ? "'" : " and '") + layout.bodies()[static_cast<std::size_t>(side.body)].name + "'";
    VectorX push = VectorX::Zero(layout.v_count()), taken = VectorX::Zero(layout.row_count());
    for (int c = 0; c < side.count; ++c) push[side.velocity + c] = rows_.values(side)[row.rows * c];
    equations.solve(push, taken);
    reactions += taken.cwiseAbs();
  }
  equations.evaluate(start.time, start.q, VectorX::Zero(layout.v_count()), Level::velocity);
  equations.constraint(Level::velocity, rate);
  std::string all, driving;
  const double least = reactions.size() > 0 ? kHolds * reactions.maxCoeff() : 0;
  for (const Layout::RowSlice& joint : layout.rows()) {
    if (joint.count == 0 || !(reactions.segment(joint.first, joint.count).maxCoeff() > least)) continue;
    const auto add = [&](std::string& list) { list += (list.empty() ? "'" : ", '") + joint.name + "'"; };
    add(all);
    if (rate.segment(joint.first, joint.count).cwiseAbs().maxCoeff() > 0) add(driving);
  }
  const std::string& holding = driving.empty() ? all : driving;
  // 2. The refusal.
  throw SimulationError("rigid surfaces of '" + contact.name() + "' meet at " + three_digits(speed) + " m/s" +
                            ", and no impulse can stop " + bodies +
                            (driving.empty() ? ": held by " : ": motion prescribed by ") + holding,
                        contact.where() + ", " + time_text(start.time),
                        "let the motion end before the surfaces meet, drive it by a spring, motor or controller of "
                        "limited effort, or give the contact a compliant law: {.law = Compliance{...}}");
}

}  // namespace lithe
