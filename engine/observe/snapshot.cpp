#include "engine/observe/snapshot.h"

#include "engine/assembly/evaluated.h"
#include "engine/assembly/least_norm.h"
#include "engine/base/error.h"
#include "engine/motion/projection.h"

namespace lithe {

Snapshot::Snapshot(const System& system) : system_(&system), evaluator_(std::make_unique<Evaluator>(system)) {}

/// Here, where Evaluator and LeastNorm are complete types.
Snapshot::~Snapshot() = default;

void Snapshot::evaluate(const State& state, Accelerations accelerations) {
  const Layout& layout = evaluator_->layout();
  if (state.q.size() != layout.q_count() || state.v.size() != layout.v_count() ||
      state.v_dot.size() != layout.v_count() || (state.lambda.size() > 0 && state.lambda.size() != layout.row_count()))
    throw SceneError("the state to look at has " + std::to_string(state.q.size()) + " coordinates, " +
                         std::to_string(state.v.size()) + " velocities, " + std::to_string(state.v_dot.size()) +
                         " accelerations and " + std::to_string(state.lambda.size()) + " multipliers; the system has " +
                         std::to_string(layout.q_count()) + ", " + std::to_string(layout.v_count()) + ", " +
                         std::to_string(layout.v_count()) + " and " + std::to_string(layout.row_count()),
                     "Snapshot", "start from system.initial_state(), or let an integrator start from the state first");
  state_ = state;
  solves_ = accelerations == Accelerations::solved;
  solved_ = has_multipliers_ = false;
  evaluator_->recall(state_.quarter_turns);
  evaluator_->recall_rows(state_.left_out);
  evaluator_->recall(state_.contacts);
  evaluator_->evaluate(state_.time, state_.q, state_.v, Level::acceleration);
  if (evaluator_->reacts() && !solve()) evaluator_->react(found_multipliers());
}

/// False: those of the state are to be used.
bool Snapshot::solve() {
  if (!solves_ || solved_) return solves_;
  solved_ = true;
  v_dot_ = state_.v_dot;
  lambda_ = state_.lambda;
  if (lambda_.size() != evaluator_->layout().row_count()) lambda_.setZero(evaluator_->layout().row_count());
  Projector(*evaluator_).accelerations(state_.time, state_.q, state_.v, v_dot_, lambda_);
  solves_ = v_dot_.allFinite() && lambda_.allFinite();
  return solves_;
}

MarkerKinematics Snapshot::marker(const Marker& marker) {
  return marker_kinematics(*evaluator_, marker, Level::acceleration);
}

BodyState Snapshot::body_state(const Body& body) { return lithe::body_state(*evaluator_, body); }

BodyEnergy Snapshot::energy() { return evaluator_->energy(); }

ContactForces* Snapshot::contacts() { return evaluator_->contacts(); }

const double* Snapshot::quarter_turns_of(const Connector& connector) const {
  return evaluator_->workspace().quarter_turns.data() + system().first_angle(connector);
}

Vector6 Snapshot::acceleration(const Marker& marker) {
  const MarkerKinematics k = this->marker(marker);
  Vector6 result;
  result << k.bias_v, k.bias_w;
  if (marker.body->coordinates().v_count() == 0) return result;  // ground
  const Layout::BodySlice& first = evaluator_->layout().slice(*marker.body);
  if (k.between) {
    for (const MarkerBetween::Share& share : k.between->shares)
      result += share.J * accelerations().segment<6>((&first)[share.frame].v);
    return result;
  }
  const Layout::BodySlice& slice = (&first)[k.frame];
  // J v_body_dot in body axes: ω̇ × r + B η̈ and ω̇ + T η̈; the frame's own acceleration is in world axes.
  Vector3 v_dot = Vector3::Zero(), w_dot = Vector3::Zero();
  const double* v_body_dot = accelerations().data() + slice.v;
  if (slice.frame) {
    const Eigen::Map<const Vector3> p_dot_dot(v_body_dot), omega_dot(v_body_dot + 3);
    result.head<3>() += p_dot_dot;
    v_dot += omega_dot.cross(k.r);
    w_dot += omega_dot;
  }
  if (k.elastic) {
    const Layout::LinearSlice eta = evaluator_->layout().linear_slice(slice);
    const Vector6 elastic =
        Eigen::Map<const Matrix6X>(k.elastic, 6, eta.size) * accelerations().segment(eta.v, eta.size);
    v_dot += elastic.head<3>();
    w_dot += elastic.tail<3>();
  }
  result.head<3>() += *k.A * v_dot;
  result.tail<3>() += *k.A * w_dot;
  return result;
}

const VectorX& Snapshot::found_multipliers() {
  if (state_.lambda.size() == evaluator_->layout().row_count()) return state_.lambda;
  state_.lambda.setZero(evaluator_->layout().row_count());
  VectorX v_dot(state_.v.size());
  Projector(*evaluator_).accelerations(state_.time, state_.q, state_.v, v_dot, state_.lambda);
  return state_.lambda;
}

const VectorX& Snapshot::multipliers() {
  const VectorX& found = solve() ? lambda_ : found_multipliers();
  if (system().redundant_rows().empty()) return found;
  if (!has_multipliers_) {
    multipliers_ = found;
    if (!least_norm_) least_norm_ = std::make_unique<LeastNorm>(system().blocks());
    least_norm_->apply(evaluator_->workspace().values, multipliers_);
    has_multipliers_ = true;
  }
  return multipliers_;
}

}  // namespace lithe
