#include "integrators/joint_friction_impulses.h"

#include <algorithm>
#include <limits>
#include <sstream>

#include "engine/base/log.h"
#include "engine/contact/rigid_contacts.h"

namespace lithe {
namespace {

// The factor is of the step's middle, the velocities are of its end: each round leaves a share of the order of the
// step. With contacts in the scene also a share of what both do to each other.
constexpr int kMaxRounds = 10, kMaxRoundsWithContacts = 200;
constexpr double kSettled = 1e-13;  // of the impulses; m or rad
constexpr double kRests = 1e-10;    // m/s

JointSurfaces* joints_of(EquationsOfMotion& equations) {
  const RigidContacts* rigid = equations.parts().rigid_contacts;
  return rigid ? rigid->joints() : nullptr;
}

// Entries at given places, without Eigen's indexed views, which copy the places at each use.
template <class From, class To>
void gather(const From& from, const std::vector<int>& places, To&& to) {
  for (std::size_t i = 0; i < places.size(); ++i) to[static_cast<Eigen::Index>(i)] = from[places[i]];
}
template <class From>
void scatter(const From& from, const std::vector<int>& places, VectorX& to) {
  for (std::size_t i = 0; i < places.size(); ++i) to[places[i]] = from[static_cast<Eigen::Index>(i)];
}
template <class From>
void scatter_sum(double factor, const From& from, const std::vector<int>& places, VectorX& to) {
  for (std::size_t i = 0; i < places.size(); ++i) to[places[i]] += factor * from[static_cast<Eigen::Index>(i)];
}
/// Solves W x = b in their place by complete pivoting, and puts `places` in the order of x. Directions that depend on
/// others get 0: they move nothing that those do not. An orthogonal decomposition would allocate in each step.
void eliminate(MatrixX& W, VectorX& x, std::vector<int>& places) {
  const Eigen::Index n = x.size();
  Eigen::Index rank = 0;
  double largest = 0;
  for (; rank < n; ++rank) {
    Eigen::Index row = 0, column = 0;
    const double pivot = W.bottomRightCorner(n - rank, n - rank).cwiseAbs().maxCoeff(&row, &column);
    largest = std::max(largest, pivot);
    if (!(pivot > static_cast<double>(n) * std::numeric_limits<double>::epsilon() * largest)) break;
    row += rank, column += rank;
    W.row(rank).swap(W.row(row)), W.col(rank).swap(W.col(column));
    std::swap(x[rank], x[row]),
        std::swap(places[static_cast<std::size_t>(rank)], places[static_cast<std::size_t>(column)]);
    for (Eigen::Index i = rank + 1; i < n; ++i) {
      const double factor = W(i, rank) / W(rank, rank);
      for (Eigen::Index j = rank + 1; j < n; ++j) W(i, j) -= factor * W(rank, j);
      x[i] -= factor * x[rank];
    }
  }
  x.tail(n - rank).setZero();
  for (Eigen::Index i = rank - 1; i >= 0; --i) {
    for (Eigen::Index j = i + 1; j < rank; ++j) x[i] -= W(i, j) * x[j];
    x[i] /= W(i, i);
  }
}
void set_zero_at(const std::vector<int>& places, VectorX& x) {
  for (const int place : places) x[place] = 0;
}

}  // namespace

void JointFrictionImpulses::prepare(EquationsOfMotion& equations) {
  static_assert(JointFrictionProblem::kMostPresses == FrictionByImpulses::kMostPresses);
  places_.clear(), of_kept_.clear(), mechanisms_.clear();
  const JointSurfaces* joints = joints_of(equations);
  if (!joints) return;
  const auto& surfaces = joints->surfaces();
  const int n = static_cast<int>(surfaces.size());
  problem_.surfaces.resize(surfaces.size()), by_lambda_.resize(surfaces.size());
  for (int i = 0; i < n; ++i) {
    const auto& surface = surfaces[i];
    for (int k = 0; k < surface.count && surface.kept >= 0; ++k)
      places_.push_back(surface.kept + k), of_kept_.push_back(surface.first + k);
    const RigidContacts& rigid = *equations.parts().rigid_contacts;
    const auto &of_A = rigid.tied_velocities(surface.joint_markers[0]),
               &tied = of_A.empty() ? rigid.tied_velocities(surface.joint_markers[1]) : of_A;
    auto mechanism =
        std::find_if(mechanisms_.begin(), mechanisms_.end(), [&](const Mechanism& m) { return m.velocities == tied; });
    if (mechanism == mechanisms_.end()) {
      mechanism = mechanisms_.insert(mechanism, Mechanism{});
      mechanism->velocities = tied;
    }
    mechanism->surfaces.push_back(i);
    auto& rows = mechanism->rows;  // several surfaces may be of one joint
    const auto at = std::find(rows.begin(), rows.end(), surface.joint_row);
    mechanism->first_rows.push_back(static_cast<int>(at - rows.begin()));
    if (at == rows.end())
      for (int row = 0; row < surface.joint->row_count(); ++row) rows.push_back(surface.joint_row + row);
    for (int k = 0; k < surface.count; ++k) mechanism->directions.emplace_back(i, k);
    auto& of = problem_.surfaces[i];
    of.first = surface.first, of.count = surface.count;
    of.friction = [&law = *surface.friction](double before, double after) { return law.friction(before, after); };
  }
}

void JointFrictionImpulses::leave_out(EquationsOfMotion& equations, State& state) {
  JointSurfaces* joints = joints_of(equations);
  if (!joints) return;
  joints->leave_out();
  equations.evaluate(state.time, state.q, state.v, Level::velocity);
  joints->find_directions();
  joints->speeds(state.v, problem_.before);
  joints->start();
  kept_.resize(static_cast<Eigen::Index>(places_.size()));
  gather(state.v, places_, kept_);
  set_zero_at(places_, state.v);
}

void JointFrictionImpulses::put_back(VectorX& v) const {
  if (!places_.empty()) scatter(kept_, places_, v);
}

void JointFrictionImpulses::keep(EquationsOfMotion& equations, double h, VectorX& v, VectorX& v_dot) const {
  if (!joints_of(equations)) return;
  for (std::size_t i = 0; i < places_.size(); ++i) v[places_[i]] = p_[of_kept_[i]] / h;
  set_zero_at(places_, v_dot);
}

void JointFrictionImpulses::add_impulses(EquationsOfMotion& equations, VectorX& to) const {
  JointSurfaces* joints = joints_of(equations);
  if (!joints) return;
  joints->find_directions();
  joints->add_impulses(p_, to);
}

int JointFrictionImpulses::place(const std::pair<int, int>& direction) const {
  return problem_.surfaces[static_cast<std::size_t>(direction.first)].first + direction.second;
}

void JointFrictionImpulses::add_moved(const VectorX& x, VectorX& to) const {
  for (const Mechanism& m : mechanisms_)
    for (std::size_t k = 0; k < m.directions.size(); ++k)
      scatter_sum(x[place(m.directions[k])], m.Y.col(static_cast<Eigen::Index>(k)), m.velocities, to);
}

void JointFrictionImpulses::add_pressed(const VectorX& x, VectorX& to) const {
  for (const Mechanism& m : mechanisms_)
    for (std::size_t k = 0; k < m.directions.size(); ++k)
      scatter_sum(x[place(m.directions[k])], m.L.col(static_cast<Eigen::Index>(k)), m.rows, to);
}

/// What unit impulses do, by the last factor: a direction of each mechanism goes into one solution.
void JointFrictionImpulses::respond(EquationsOfMotion& equations) {
  JointSurfaces& joints = *joints_of(equations);
  joints.find_directions();
  problem_.W.setZero(joints.directions(), joints.directions());
  std::size_t most = 0;
  for (Mechanism& m : mechanisms_) {
    const auto count = static_cast<Eigen::Index>(m.directions.size());
    m.Y.resize(static_cast<Eigen::Index>(m.velocities.size()), count);
    m.L.resize(static_cast<Eigen::Index>(m.rows.size()), count);
    most = std::max(most, m.directions.size());
  }
  for (std::size_t k = 0; k < most; ++k) {
    rv_.setZero(), rl_.setZero();
    for (const Mechanism& m : mechanisms_)
      if (k < m.directions.size()) joints.add_direction(m.directions[k].first, m.directions[k].second, rv_);
    equations.solve(rv_, rl_);
    joints.felt(rl_);
    joints.speeds(rv_, speeds_);
    for (Mechanism& m : mechanisms_) {
      if (k >= m.directions.size()) continue;
      const auto column = static_cast<Eigen::Index>(k);
      gather(rv_, m.velocities, m.Y.col(column));
      gather(rl_, m.rows, m.L.col(column));
      for (const auto& direction : m.directions)
        problem_.W(place(direction), place(m.directions[k])) = speeds_[place(direction)];
    }
  }
  for (std::size_t i = 0; i < by_lambda_.size(); ++i) joints.find_presses(joints.surfaces()[i], by_lambda_[i]);
}

void JointFrictionImpulses::form(EquationsOfMotion& equations, double h) {
  const auto& surfaces = joints_of(equations)->surfaces();
  for (const Mechanism& m : mechanisms_) {
    for (std::size_t s = 0; s < m.surfaces.size(); ++s) {
      const int i = m.surfaces[s], row = m.first_rows[s];
      const auto& surface = surfaces[i];
      auto& of = problem_.surfaces[i];
      of.load = h * surface.friction->load();
      of.presses.resize(by_lambda_[i].size());
      const int count = surface.joint->row_count();
      for (std::size_t k = 0; k < of.presses.size(); ++k) {
        const Matrix3X& by = by_lambda_[i][k];
        auto& press = of.presses[k];
        press.by.setZero(3, p_.size());
        for (std::size_t j = 0; j < m.directions.size(); ++j)
          press.by.col(place(m.directions[j])).noalias() =
              by * m.L.col(static_cast<Eigen::Index>(j)).segment(row, count);
        press.constant = by * felt_.segment(surface.joint_row, count) - press.by * p_;
      }
    }
  }
}

/// Moves positions so that surfaces which rested before the step and stick in it have not slid.
void JointFrictionImpulses::hold(VectorX& correction) {
  held_.clear();
  for (std::size_t i = 0; i < sticks_.size(); ++i) {
    const auto& surface = problem_.surfaces[i];
    if (!sticks_[i] || problem_.before.segment(surface.first, surface.count).norm() > kRests) continue;
    for (int k = 0; k < surface.count; ++k) held_.push_back(surface.first + k);
  }
  if (held_.empty()) return;
  const auto count = static_cast<Eigen::Index>(held_.size());
  held_W_.resize(count, count), held_way_.resize(count);
  for (Eigen::Index i = 0; i < count; ++i) gather(problem_.W.col(held_[i]), held_, held_W_.col(i));
  gather(way_, held_, held_way_);
  x_.setZero(p_.size());
  held_way_ = -held_way_;
  eliminate(held_W_, held_way_, held_);
  scatter(held_way_, held_, x_);
  add_moved(x_, correction);
}

/// Rounds of joints and contacts converge as a geometric series, slowly where what one gives lands on the other (a
/// heavy body on a light one that jams): Irons and Tuck's vector form of Aitken's rule goes to its limit. `factor`:
/// that of the last round; 0: there was none.
void JointFrictionImpulses::relax(double& factor) {
  constexpr double kLeast = 0.1, kMost = 100;
  residual_ = p_ - last_;
  if (factor == 0) {
    factor = 1;
  } else {
    residual_before_ -= residual_;
    const double size = residual_before_.squaredNorm();
    factor = size > 0 ? std::clamp(factor * (residual_before_.dot(residual_) / size + 1), kLeast, kMost) : 1;
  }
  residual_before_ = residual_;
  p_ = last_ + factor * residual_;
}

/// What contacts do to the rows of joints.
void JointFrictionImpulses::feel(EquationsOfMotion& equations, const ContactImpulses& contacts) {
  rv_.setZero(), hit_rows_.setZero();
  equations.parts().rigid_contacts->add_impulses(contacts.total(), rv_);
  equations.solve(rv_, hit_rows_);
}

bool JointFrictionImpulses::apply(EquationsOfMotion& equations, const State& start, double time,
                                  ContactImpulses* contacts, VectorX& rows, const VectorX& d, VectorX& q, VectorX& v) {
  JointSurfaces* joints = joints_of(equations);
  if (!joints) return false;
  const Layout& layout = equations.layout();
  const double h = time - start.time;
  sweeps_ = 0;
  rv_.resize(v.size()), rl_.resize(rows.size());
  respond(equations);
  p_.setZero(joints->directions());
  for (VectorX* x : {&closed_, &corrected_, &hit_v_, &hit_d_}) x->setZero(v.size());
  hit_rows_.setZero(rows.size());
  const auto end_of_step = [&] {
    moved_.setZero(v.size());
    add_moved(p_, moved_);
    v_ = v + closed_ + moved_;
    d_ = d + h / 2 * moved_;
  };
  const int most = contacts ? kMaxRoundsWithContacts : kMaxRounds;
  JointFrictionProblem::Result result{};
  bool settled = false;
  double change = 0;  // of an impulse in a round, N s
  double factor = 0;  // of relax()
  for (int round = 0; round < most && !settled; ++round) {
    // 1. The end of the step by the impulses so far.
    end_of_step();
    if (contacts && round == 1) alone_ = moved_;
    if (contacts && round > 0) {
      brought_ = moved_ - alone_;
      hit_v_ = v_, hit_d_ = d_;
      const ContactImpulses::Others others{moved_, brought_};
      contacts->act(equations, start, h, v_, d_, &others);
      if (contacts->cut() > 0) return true;
      hit_v_ = v_ - hit_v_, hit_d_ = d_ - hit_d_;
      feel(equations, *contacts);
    }
    layout.retract(start.q, d_, q);
    layout.retract(q, corrected_, q);
    equations.evaluate(time, q, v_, Level::velocity);
    // 2. Joints closed there, in velocity and position.
    equations.constraint(Level::velocity, rl_);
    rl_ = -rl_;
    rv_.setZero();
    equations.solve(rv_, rl_);
    closed_ += rv_, v_ += rv_, rows += rl_;
    equations.constraint(Level::position, rl_);
    rl_ = -rl_;
    for (int row : equations.velocity_rows()) rl_[row] = 0;
    rv_.setZero();
    equations.solve(rv_, rl_);
    // 3. Impulses anew, by how the surfaces slide there.
    joints->find_directions();
    joints->speeds(v_, problem_.free);
    problem_.free.noalias() -= problem_.W * p_;
    felt_ = rows + hit_rows_;
    joints->felt(felt_);
    add_pressed(p_, felt_);
    form(equations, h);
    last_ = p_;
    result = problem_.solve(p_, sticks_);
    sweeps_ += result.sweeps;
    change = (p_ - last_).lpNorm<Eigen::Infinity>();
    const bool same = change <= kSettled * p_.lpNorm<Eigen::Infinity>();
    if (contacts && round > 1 && !same) relax(factor);
    // 4. What sticks stays where it was.
    joints->slid(way_);
    x_ = h / 2 * (p_ - last_);
    moved_ = rv_;
    add_moved(x_, moved_);
    joints->speeds(moved_, speeds_);
    way_ += speeds_;
    hold(rv_);
    corrected_ += rv_;
    if (!p_.allFinite()) break;
    settled = (!contacts || round > 1) && same &&
              rv_.lpNorm<Eigen::Infinity>() <= kSettled * std::max(1.0, q.lpNorm<Eigen::Infinity>());
  }
  end_of_step();
  v = v_ + hit_v_;
  d_ += hit_d_;
  layout.retract(start.q, d_, q);
  layout.retract(q, corrected_, q);
  if ((!result.converged || (contacts && !settled)) && !warned_) {
    warned_ = true;
    std::ostringstream message;
    message << "friction in joints: after " << sweeps_ << " sweeps an impulse still changes by "
            << std::max(result.change, change) << " N s at t = " << time
            << " s (later steps are not reported)\n  fix:  a smaller step.";
    log::warn(message.str());
  }
  return true;
}

}  // namespace lithe
