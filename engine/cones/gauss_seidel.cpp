#include "engine/cones/gauss_seidel.h"

#include "engine/cones/friction_block.h"

namespace lithe {
namespace {

using Matrix63 = Eigen::Matrix<double, 6, 3>;
using Free = Eigen::Map<const Matrix63>;
using Block = Eigen::Map<const MatrixX>;
constexpr int kFreeBody = 36;

bool is_free_body(const ConeProblem& problem, const ConeProblem::Side& side) {
  return side.count == 6 && problem.groups[side.group].size == 6;
}

}  // namespace

void GaussSeidel::prepare(const ConeProblem& problem, VectorX& r) {
  if (r.size() != problem.rows || !r.allFinite()) r.setZero(problem.rows);
  problem.velocity(r, u_, v_);
  steps_.clear();
  packed_.clear();
  moment_blocks_.clear();
  for (int i = 0; i < static_cast<int>(problem.contacts.size()); ++i) {
    const auto& contact = problem.contacts[i];
    steps_.push_back({Kind::general,
                      i,
                      contact.row,
                      -1,
                      {},
                      contact.friction,
                      Matrix3::Zero(),
                      problem.free.segment<3>(contact.row)});
    Step& step = steps_.back();
    int moving = 0, free_bodies = 0;
    for (const auto& a : contact.sides) {
      if (a.group < 0) continue;
      ++moving;
      free_bodies += is_free_body(problem, a);
    }
    // Two sides in one group (two links of a mechanism) move each other: their blocks do not add up apart.
    const bool of_one_group = contact.sides[0].group == contact.sides[1].group;
    if (contact.rows == 3 && moving > 0 && free_bodies == moving && !of_one_group) {
      step.kind = moving == 1 ? Kind::one_free_body : Kind::two_free_bodies;
      step.data = static_cast<int>(packed_.size());
      packed_.resize(packed_.size() + moving * kFreeBody);
      int k = 0;
      for (const auto& side : contact.sides) {
        if (side.group < 0) continue;
        double* place = packed_.data() + step.data + k * kFreeBody;
        Eigen::Map<Matrix63> H(place), Y(place + 18);
        // H and Y side by side, in the order in which a sweep reads them: sweeps are bound by memory.
        H = Eigen::Map<const Eigen::Matrix<double, 3, 6>>(problem.values.data() + side.H).transpose();
        Y = Free(problem.values.data() + side.Y);
        step.W += H.transpose().lazyProduct(Y);
        step.v[k++] = problem.groups[side.group].first;
      }
      continue;
    }
    Matrix6 W = Matrix6::Zero();
    for (const auto& a : contact.sides)
      for (const auto& b : contact.sides) {
        if (a.group < 0 || a.group != b.group) continue;
        const Block H(problem.values.data() + a.H, contact.rows, a.count);
        const Block Y(problem.values.data() + b.Y, problem.groups[b.group].size, contact.rows);
        W.topLeftCorner(contact.rows, contact.rows) += H.lazyProduct(Y.middleRows(a.first, a.count));
      }
    step.W = W.topLeftCorner<3, 3>();
    if (contact.rows == 6) {
      step.data = static_cast<int>(moment_blocks_.size());
      moment_blocks_.push_back(W);
    }
  }
}

Vector3 GaussSeidel::local_impulse(const Step& step, const Vector3& u, const Vector3& old) const {
  // u holds what this contact's own impulse adds; the block is solved for the impulse as a whole, without it.
  if (parameters_.exact_blocks) return friction_block::solve(step.W, u - step.W * old, step.friction);
  Vector3 r = old;
  r[0] = step.W(0, 0) > 0 ? std::max(0.0, old[0] - u[0] / step.W(0, 0)) : 0;
  // One projected step instead: normal by its own diagonal, friction by the larger of its two.
  const double across = std::max(step.W(1, 1), step.W(2, 2));
  if (across > 0) r.tail<2>() -= u.tail<2>() / across;
  r.tail<2>() = friction_block::project_on_disc(friction_block::Vector2(r.tail<2>()), step.friction * r[0]);
  return r;
}

template <int bodies>
double GaussSeidel::relax_free(const Step& step, VectorX& r) {
  const double* data = packed_.data() + step.data;
  Vector3 u = step.free;
  for (int k = 0; k < bodies; ++k)
    u.noalias() += Free(data + k * kFreeBody).transpose().lazyProduct(v_.segment<6>(step.v[k]));
  const Vector3 old = r.segment<3>(step.row), now = local_impulse(step, u, old), change = now - old;
  r.segment<3>(step.row) = now;
  for (int k = 0; k < bodies; ++k)
    v_.segment<6>(step.v[k]).noalias() += Free(data + k * kFreeBody + 18).lazyProduct(change);
  return change.lpNorm<Eigen::Infinity>();
}

double GaussSeidel::relax_general(const ConeProblem& problem, const Step& step, VectorX& r) {
  using friction_block::Matrix2, friction_block::Vector2;
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 6>;  // three or six
  const auto& contact = problem.contacts[step.contact];
  const int n = contact.rows;
  Rows u = problem.free.segment(step.row, n), change = Rows::Zero(n);
  const Rows old = r.segment(step.row, n);
  for (const auto& side : contact.sides)
    if (side.group >= 0)
      u += Block(problem.values.data() + side.H, n, side.count)
               .lazyProduct(v_.segment(problem.groups[side.group].first + side.first, side.count));
  const Vector3 force = local_impulse(step, u.head<3>(), old.head<3>());
  change.head<3>() = force - old.head<3>();
  if (n == 6) {
    const Matrix6& W = moment_blocks_[step.data];
    const Matrix2 W_roll = W.block<2, 2>(3, 3);
    const Vector2 roll = old.segment<2>(3);
    const Vector2 q = u.segment<2>(3) + W.block<2, 3>(3, 0) * change.head<3>() - W_roll * roll;
    change.segment<2>(3) = friction_block::solve_disc(W_roll, q, contact.rolling * force[0]) - roll;
    // Rolling and spinning follow with the limits of the new normal impulse, one after the other in the block.
    const double q_spin = u[5] + W.block<1, 5>(5, 0).dot(change.head<5>()) - W(5, 5) * old[5];
    change[5] = friction_block::solve_interval(W(5, 5), q_spin, contact.spinning * force[0]) - old[5];
  }
  r.segment(step.row, n) += change;
  r.segment<3>(step.row) = force;  // its sum may miss zero by round-off
  for (const auto& side : contact.sides) {
    if (side.group < 0) continue;
    const auto& group = problem.groups[side.group];
    v_.segment(group.first, group.size) += Block(problem.values.data() + side.Y, group.size, n).lazyProduct(change);
  }
  return change.lpNorm<Eigen::Infinity>();
}

ConeResult GaussSeidel::solve(const ConeProblem& problem, double tolerance, VectorX& r) {
  prepare(problem, r);
  ConeResult result;
  result.residual = problem.residual(r, u_);
  // At least one sweep: what the impulses given miss by less than the tolerance dies out, step by step, instead of
  // letting what rests creep.
  while (result.residual > 0 && result.iterations < parameters_.sweeps) {
    double change = 0;
    for (const Step& step : steps_) {
      double moved = 0;
      switch (step.kind) {
        case Kind::one_free_body:
          moved = relax_free<1>(step, r);
          break;
        case Kind::two_free_bodies:
          moved = relax_free<2>(step, r);
          break;
        case Kind::general:
          moved = relax_general(problem, step, r);
          break;
      }
      change = std::max(change, moved);
    }
    ++result.iterations;
    // What a sweep moves is the residual it found, or near to it: only then is it worth to ask.
    if (change > 2 * tolerance && result.iterations < parameters_.sweeps) continue;
    problem.velocity(r, u_, v_);
    result.residual = problem.residual(r, u_);
    if (result.residual <= tolerance) break;
  }
  result.converged = result.residual <= tolerance;
  // Bodies of infinite response end here: no impulses, and not converged, rather than NaN in the state.
  if (!r.allFinite()) {
    r.setZero();
    problem.velocity(r, u_, v_);
    result = {false, result.iterations, problem.residual(r, u_)};
  }
  return result;
}

}  // namespace lithe
