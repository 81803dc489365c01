#include "engine/cones/cone_problem.h"

#include <algorithm>

#include "engine/cones/friction_block.h"

namespace lithe {
namespace {

using Block = Eigen::Map<const MatrixX>;

Block directions(const ConeProblem& problem, const ConeProblem::Contact& contact, const ConeProblem::Side& side) {
  return {problem.values.data() + side.H, contact.rows, side.count};
}
Block response(const ConeProblem& problem, const ConeProblem::Contact& contact, const ConeProblem::Side& side) {
  return {problem.values.data() + side.Y, problem.groups[side.group].size, contact.rows};
}

/// v += Y r and u += H v, in fixed sizes for a free body and three rows: most contacts of most scenes.
void add_response(const ConeProblem& problem, const ConeProblem::Contact& contact, const ConeProblem::Side& side,
                  const VectorX& r, VectorX& v) {
  const auto& group = problem.groups[side.group];
  if (contact.rows == 3 && group.size == 6)
    v.segment<6>(group.first) += Eigen::Map<const Eigen::Matrix<double, 6, 3>>(problem.values.data() + side.Y)
                                     .lazyProduct(r.segment<3>(contact.row));
  else
    v.segment(group.first, group.size) +=
        response(problem, contact, side).lazyProduct(r.segment(contact.row, contact.rows));
}
void add_velocity(const ConeProblem& problem, const ConeProblem::Contact& contact, const ConeProblem::Side& side,
                  const VectorX& v, VectorX& u) {
  const int first = problem.groups[side.group].first + side.first;
  if (contact.rows == 3 && side.count == 6)
    u.segment<3>(contact.row) +=
        Eigen::Map<const Eigen::Matrix<double, 3, 6>>(problem.values.data() + side.H).lazyProduct(v.segment<6>(first));
  else
    u.segment(contact.row, contact.rows) +=
        directions(problem, contact, side).lazyProduct(v.segment(first, side.count));
}

/// Diagonal of the contact's own block.
Vector6 diagonal(const ConeProblem& problem, const ConeProblem::Contact& contact) {
  Vector6 sum = Vector6::Zero();
  for (const auto& a : contact.sides)
    for (const auto& b : contact.sides) {
      if (a.group < 0 || a.group != b.group) continue;
      const double* H = problem.values.data() + a.H;
      const double* Y = problem.values.data() + b.Y + a.first;
      const int size = problem.groups[b.group].size;
      if (contact.rows == 3 && a.count == 6 && size == 6) {
        for (int row = 0; row < 3; ++row)
          for (int k = 0; k < 6; ++k) sum[row] += H[3 * k + row] * Y[6 * row + k];
        continue;
      }
      for (int k = 0; k < a.count; ++k)
        for (int row = 0; row < contact.rows; ++row) sum[row] += H[k * contact.rows + row] * Y[row * size + k];
    }
  return sum;
}

double inverse_of_largest(const Vector6& diagonal, int first, int count) {
  const double largest = diagonal.segment(first, count).maxCoeff();
  return largest > 0 ? 1 / largest : 0;
}

}  // namespace

void ConeProblem::velocity(const VectorX& r, VectorX& u) const {
  VectorX v;
  velocity(r, u, v);
}

void ConeProblem::velocity(const VectorX& r, VectorX& u, VectorX& v) const {
  v.setZero(velocities);
  for (const Contact& contact : contacts)
    for (const Side& side : contact.sides)
      if (side.group >= 0) add_response(*this, contact, side, r, v);
  u = free;
  for (const Contact& contact : contacts)
    for (const Side& side : contact.sides)
      if (side.group >= 0) add_velocity(*this, contact, side, v, u);
}

MatrixX ConeProblem::block(int i, int j) const {
  MatrixX W = MatrixX::Zero(contacts[i].rows, contacts[j].rows);
  for (const Side& a : contacts[i].sides)
    for (const Side& b : contacts[j].sides)
      if (a.group >= 0 && a.group == b.group)
        W += directions(*this, contacts[i], a) * response(*this, contacts[j], b).middleRows(a.first, a.count);
  return W;
}

MatrixX ConeProblem::delassus() const {
  // Contacts by group, so that only those that share one are paired.
  std::vector<std::vector<std::pair<const Contact*, const Side*>>> sides(groups.size());
  for (const Contact& contact : contacts)
    for (const Side& side : contact.sides)
      if (side.group >= 0) sides[side.group].emplace_back(&contact, &side);
  MatrixX W = MatrixX::Zero(rows, rows);
  for (const auto& group : sides)
    for (const auto& [i, a] : group)
      for (const auto& [j, b] : group)
        W.block(i->row, j->row, i->rows, j->rows) +=
            directions(*this, *i, *a).lazyProduct(response(*this, *j, *b).middleRows(a->first, a->count));
  return W;
}

double ConeProblem::violation(const Contact& contact, const VectorX& r, const VectorX& u) const {
  using friction_block::Vector2;
  const Vector3 impulse = r.segment<3>(contact.row), motion = u.segment<3>(contact.row);
  const Vector6 W = diagonal(*this, contact);
  // t turns a velocity into the impulse that it takes here, so that the residual is an impulse for any mass.
  double t = inverse_of_largest(W, 0, 3);
  Vector3 lifted = motion;
  // De Saxcé's bipotential: with μ |u_t| added to the normal velocity, Coulomb's law is one projection on the cone.
  lifted[0] += contact.friction * motion.tail<2>().norm();
  double largest = (impulse - friction_block::project_on_cone(impulse - t * lifted, contact.friction)).norm();
  if (contact.rows == 3) return largest;
  const double normal = std::max(0.0, impulse[0]);
  const Vector2 roll = r.segment<2>(contact.row + 3);
  t = inverse_of_largest(W, 3, 2);
  const Vector2 rolling = roll - t * u.segment<2>(contact.row + 3);
  largest = std::max(largest, (roll - friction_block::project_on_disc(rolling, contact.rolling * normal)).norm());
  const double spin = r[contact.row + 5], limit = contact.spinning * normal;
  t = inverse_of_largest(W, 5, 1);
  return std::max(largest, std::abs(spin - std::clamp(spin - t * u[contact.row + 5], -limit, limit)));
}

double ConeProblem::residual(const VectorX& r, const VectorX& u) const {
  double largest = 0;
  for (const Contact& contact : contacts)
    if (const double off = violation(contact, r, u); !(off <= largest)) largest = off;  // NaN included
  return largest;
}

}  // namespace lithe
