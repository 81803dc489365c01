#include "engine/assembly/evaluator.h"

#include <algorithm>

#include "engine/assembly/evaluated.h"
#include "engine/assembly/find_joint_surfaces.h"
#include "engine/assembly/forward_part.h"
#include "engine/assembly/held_blocks.h"
#include "engine/assembly/least_norm.h"
#include "engine/assembly/reached_state.h"
#include "engine/assembly/tangent_factors.h"
#include "engine/base/error.h"
#include "engine/base/thread_team.h"
#include "engine/contact/rigid_contacts.h"
#include "engine/factor/block_products.h"

namespace lithe {
namespace {

/// Whether a contact that a state remembers is between surfaces that the scene has.
bool is_of(const std::vector<ContactRecord>& contacts, const ContactTrace& trace) {
  if (trace.element < 0 || trace.element >= std::ssize(contacts)) return false;
  const std::vector<Marker>& markers = contacts[static_cast<std::size_t>(trace.element)].markers;
  const auto has = [&](const ContactSide& side) {
    if (side.collider < 0 || side.collider >= std::ssize(markers)) return false;
    const int most = markers[static_cast<std::size_t>(side.collider)].body->marker_count();
    return side.node_count >= 0 && side.node_count <= std::ssize(side.nodes) &&
           std::all_of(side.nodes.begin(), side.nodes.begin() + side.node_count,
                       [&](int node) { return node >= 0 && node < most; });
  };
  return has(trace.point.A) && has(trace.point.B);
}

}  // namespace

Evaluator::Evaluator(const System& system)
    : system_(system), team_(std::make_unique<ThreadTeam>(system.parts().size() > 1 ? system.threads_ : 1)) {
  const auto& layout = system.layout();
  const int rows = layout.row_count(), compliant = system.compliant_count_;
  work_.q.setZero(layout.q_count());
  work_.v.setZero(layout.v_count());
  work_.gravity = system.gravity();
  work_.markers.resize(system.marker_count_);
  work_.values.assign(system.blocks_.value_count, 0.0);
  for (VectorX* x : {&work_.residual, &work_.rate, &work_.bias}) x->setZero(rows);
  for (VectorX* x : {&work_.tension, &work_.row_stiffness, &work_.row_damping}) x->setZero(compliant);
  work_.load.setZero(layout.v_count());
  work_.quarter_turns = system.initial_.quarter_turns;
  work_.quarter_turns.conservativeResize(static_cast<int>(system.angles_.size()));
  work_.force_energy.setZero(system.graph().load_count());
  for (const auto& batch : system.batches_.bodies) caches_.push_back(batch->make_caches());
  facts_.layout = &layout;
  make_contacts();
  held_ = std::make_unique<HeldBlocks>(system.blocks_, work_, contacts_.get());
  factors_ = std::make_unique<TangentFactors>(*this, work_, facts_.redundant_rows, contacts_.get());
  facts_ = {.layout = &layout,
            .redundant_rows = {},
            .velocity_rows = system.velocity_rows(),
            .reacts = system.reacts_,
            .has_loops = factors_->has_loops(),
            .team = team_.get()};
  for (const RedundantRow& r : system.redundant_) facts_.redundant_rows.push_back(r.row);
  factors_->drop_rows(facts_.redundant_rows);
  if (system.forward_method_ != ForwardMethod::constraints)
    forward_ = std::make_unique<ForwardPart>(system, system.threads_, *this);
  reached_ = ReachedState::make(*this);
}

template <class Job>
void Evaluator::for_each_part(const Job& job) {
  team_->run(static_cast<int>(system_.parts().size()), [&](int i) { job(static_cast<std::size_t>(i)); });
}

/// Here, where the parts are complete types.
Evaluator::~Evaluator() = default;

/// Contact elements, and joints whose friction is found as theirs is.
void Evaluator::make_contacts() {
  const bool sticks = has_set_valued_friction(system_.graph());
  if (system_.contacts().empty() && !sticks) return;
  const auto& slices = layout().bodies();
  std::vector<BodyState> bodies;
  for (const auto& slice : slices) bodies.push_back(lithe::body_state(*this, *slice.body));
  contacts_ = std::make_unique<ContactForces>(system_.contacts(), layout(), work_.markers, work_.v, std::move(bodies));
  if (!contacts_->any_rigid() && !sticks) return;
  // Frames of bodies on which force elements act: their loads have tangents.
  std::vector<int> loaded;
  for (const auto& entry : system_.graph().forces())
    for (const Marker& m : entry.markers) {
      const Coordinates has = m.body->coordinates();
      if (has.v_count() == 0) continue;  // ground
      const int first = static_cast<int>(&layout().slice(*m.body) - slices.data());
      const int slices_of_it = std::max(1, has.frames) + (has.frames > 1 && has.linear > 0);
      for (int i = 0; i < slices_of_it; ++i) loaded.push_back(first + i);
    }
  rigid_contacts_ = std::make_unique<RigidContacts>(
      RigidContacts::Scene{*this, system_.blocks_, work_.values, system_.contacts(), *contacts_, std::move(loaded),
                           system_.gravity().norm(), find_joint_surfaces(*this, work_.friction_left_out)});
}

void Evaluator::recall(const ContactMemory& contacts) {
  work_.friction_left_out = false;
  if (!contacts_) return;
  for (const ContactTrace& trace : contacts)
    if (!is_of(system_.contacts(), trace))
      throw SceneError("the state remembers a contact that this scene does not have", "State::contacts",
                       "start from system.initial_state(), or from a checkpoint of this scene");
  contacts_->recall(contacts);
}

EquationsOfMotion::Parts Evaluator::parts() {
  return {.memory = this,
          .complex_factor = factors_.get(),
          .forward_dynamics = forward_.get(),
          .rigid_contacts = rigid_contacts_.get(),
          .held = held_.get()};
}

void Evaluator::track_contacts(State& state) {
  if (!contacts_ || !contacts_->remembers()) return;
  evaluate(state.time, state.q, state.v, Level::velocity);
  contacts_->track(state.contacts);
}

bool Evaluator::loses_angle(const State& state) { return reached_ && reached_->loses_angle(state); }

void Evaluator::check(const State& state) {
  if (reached_) reached_->check(state);
}

const double* Evaluator::applied_forces(double time, ConstVectorRef q, ConstVectorRef v) {
  if (!has_forces()) return nullptr;
  work_.time = time;
  work_.q = q;
  work_.v = v;
  for_each_part([&](std::size_t part) {
    for (std::size_t b = 0; b < caches_.size(); ++b) {
      const BodyBatch& batch = *system_.batches_.bodies[b];
      batch.evaluate_loaded(work_, *caches_[b], batch.part(part), Level::velocity);
    }
  });
  add_applied_forces();
  if (work_.tension.size() > 0) {
    work_.tension = -work_.tension;
    add_row_forces(system_.blocks_, work_.values, layout().row_count(), nullptr, work_.tension.data(),
                   work_.load.data());
    work_.tension = -work_.tension;
  }
  return work_.load.data();
}

/// Loads, tensions and contacts of the state whose markers are evaluated.
void Evaluator::add_applied_forces() {
  const auto evaluate = [&](std::size_t part) {
    for (const auto& batch : system_.batches_.forces)
      if (const BatchRange range = batch->part(part); !range.empty()) batch->evaluate(work_, range, system_.blocks_);
  };
  for_each_part([&](std::size_t part) {
    const System::Part& of = system_.parts()[part];
    work_.load.segment(of.first_v, of.last_v - of.first_v).setZero();
    evaluate(part);
  });
  evaluate(system_.parts().size());
  if (contacts_) contacts_->evaluate(work_.load, work_.force_energy);
}

void Evaluator::place_measured_angles(ConstVectorRef q) {
  if (system_.angles_.empty()) return;
  work_.q = q;
  for_each_part([&](std::size_t part) {
    for (std::size_t b = 0; b < caches_.size(); ++b) {
      const BodyBatch& batch = *system_.batches_.bodies[b];
      batch.evaluate(work_, *caches_[b], batch.part(part), Level::position, Level::position);
    }
  });
}

void Evaluator::recall(const VectorX& quarter_turns) {
  if (quarter_turns.size() == work_.quarter_turns.size()) work_.quarter_turns = quarter_turns;
}

/// The quarter turns in which (cos, sin) lies, as a number that grows with the angle: exact at every quarter turn and
/// never far off between, at the price of a division. With it the turn count needs no arc tangent a step.
void Evaluator::track(VectorX& quarter_turns) const {
  quarter_turns.resize(work_.quarter_turns.size());
  for (std::size_t i = 0; i < system_.angles_.size(); ++i) {
    const System::Angle& angle = system_.angles_[i];
    const MarkerKinematics &A = work_.markers[angle.A], &B = work_.markers[angle.B];
    const int next = (angle.axis + 1) % 3;
    const Vector3 u = angle.to_point ? Vector3(B.p - A.p) : Vector3(B.R.col(next));
    const double c = u.dot(A.R.col(next)), s = u.dot(A.R.col((angle.axis + 2) % 3));
    const double sum = std::abs(c) + std::abs(s);
    const double part = sum > 0 ? s / sum : 0, within = c >= 0 ? part : std::copysign(2, s) - part;
    // Half a turn from the last count keeps its sign: ties go to even, here no turn.
    quarter_turns[i] = within + 4 * std::nearbyint((work_.quarter_turns[i] - within) / 4);
  }
}

/// The multipliers that joints which rub feel. Where rows repeat others, λ is known up to a part that makes no force,
/// and a method's is what its left-out rows make it: of least norm it does not depend on that choice. A Newton
/// iteration asks twice, for its residual and its tangent: the first answer serves both.
const double* Evaluator::as_felt(ConstVectorRef lambda) {
  if (facts_.redundant_rows.empty() || !lambda.allFinite()) return lambda.data();
  if (!least_norm_) least_norm_ = std::make_unique<LeastNorm>(system_.blocks_);
  return least_norm_->of(work_.values, lambda).data();
}

void Evaluator::react(ConstVectorRef lambda) {
  if (!system_.reacts_) return;
  const double* felt = as_felt(lambda);
  for (const auto& batch : system_.batches_.forces) batch->react(work_, system_.blocks_, felt);
}

void Evaluator::evaluate(double time, ConstVectorRef q, ConstVectorRef v, Level level) {
  ++evaluations_;
  work_.time = time;
  // Joints ask for the velocities of markers where the velocity terms of g̈ or rows on velocities are wanted.
  const bool no_velocities = level == Level::velocity && !has_forces() && system_.velocity_rows_.empty();
  const Level markers = no_velocities ? Level::position : level;
  if (least_norm_) least_norm_->forget();
  // Joints of a part right after its bodies, whose markers are still in the cache; ground's markers before all.
  const auto& bodies = system_.batches_.bodies;
  const auto& joints = system_.batches_.constraints;
  bodies.front()->evaluate(work_, *caches_.front(), bodies.front()->part(0), level, markers);
  for_each_part([&](std::size_t part) {
    const System::Part& of = system_.parts()[part];
    const int q_count = of.last_q - of.first_q, v_count = of.last_v - of.first_v;
    work_.q.segment(of.first_q, q_count) = q.segment(of.first_q, q_count);
    work_.v.segment(of.first_v, v_count) = v.segment(of.first_v, v_count);
    for (std::size_t b = 1; b < caches_.size(); ++b)
      bodies[b]->evaluate(work_, *caches_[b], bodies[b]->part(part), level, markers);
    for (const auto& batch : joints)
      if (const BatchRange range = batch->part(part); !range.empty())
        batch->evaluate(work_, range, system_.blocks_, level);
  });
  // Those between parts write rows and blocks of their own.
  const std::size_t parts = system_.parts().size();
  for_each_part([&](std::size_t share) {
    for (const auto& batch : joints) {
      const BatchRange between = batch->part(parts);
      const auto at = [&](std::size_t i) {
        return between.first + static_cast<int>(static_cast<std::size_t>(between.last - between.first) * i / parts);
      };
      if (at(share) < at(share + 1)) batch->evaluate(work_, {at(share), at(share + 1)}, system_.blocks_, level);
    }
  });
  if (level != Level::position && has_forces()) add_applied_forces();
  if (held_->any()) held_->release_from_joints();
}

void Evaluator::residual(ConstVectorRef v_dot, ConstVectorRef lambda, VectorRef r) {
  react(lambda);
  const bool loaded = has_forces();
  for_each_part([&](std::size_t part) {
    const System::Part& of = system_.parts()[part];
    const int count = of.last_v - of.first_v;
    if (loaded)
      r.segment(of.first_v, count) = -work_.load.segment(of.first_v, count);
    else
      r.segment(of.first_v, count).setZero();
    for (std::size_t b = 0; b < caches_.size(); ++b) {
      const BodyBatch& batch = *system_.batches_.bodies[b];
      batch.add_residual(work_, *caches_[b], batch.part(part), v_dot.data(), r.data());
    }
    add_row_forces(system_.blocks_, work_.values, of.jacobians, static_cast<int>(work_.residual.size()), lambda.data(),
                   work_.tension.data(), r.data());
  });
  held_->write_residual(v_dot, r);
}

void Evaluator::constraint(Level which, VectorRef out) const {
  if (which == Level::position) {
    out = work_.residual;
    return;
  }
  if (which == Level::acceleration) {
    out = -work_.bias;
    return;
  }
  out = work_.rate;
  add_rates(system_.blocks_, work_.values, work_.v.data(), out);
}

void Evaluator::write_tangent(const TangentWeights& weights, ConstVectorRef v_dot, ConstVectorRef lambda,
                              const VectorX* increment) {
  const auto& blocks = system_.blocks_;
  double* values = work_.values.data();
  for_each_part([&](std::size_t part) {
    const System::Part& of = system_.parts()[part];
    for (int i = of.first_coupling; i < of.last_coupling; ++i)
      std::fill_n(values + blocks.couplings[i].ab, 36, 0.0), std::fill_n(values + blocks.couplings[i].ba, 36, 0.0);
    for (std::size_t b = 0; b < caches_.size(); ++b) {
      const BodyBatch& batch = *system_.batches_.bodies[b];
      batch.write_tangent(work_, *caches_[b], batch.part(part), blocks, v_dot.data(), weights,
                          increment ? increment->data() : nullptr);
    }
    add_part_tangent(part, weights, lambda);
  });
  add_part_tangent(system_.parts().size(), weights, lambda);
  const int rows = static_cast<int>(work_.residual.size());
  for (const auto& row : blocks.rows) {
    if (row.compliant < 0) continue;
    for (int i = 0; i < row.count; ++i) {
      const int k = row.first - rows + i;
      const double stiffness = weights.position * work_.row_stiffness[k] + weights.velocity * work_.row_damping[k];
      values[row.compliant + i] = stiffness == 0 ? -1e30 : -1 / stiffness;  // no stiffness: the row gives way
    }
  }
  if (system_.reacts_) {
    const double* felt = as_felt(lambda);
    for (const auto& batch : system_.batches_.forces) batch->write_reaction_tangent(work_, blocks, felt);
  }
  held_->write_tangent(weights.acceleration);
}

/// Of the joints and forces of a part, or of those between parts.
void Evaluator::add_part_tangent(std::size_t part, const TangentWeights& weights, ConstVectorRef lambda) {
  const auto& blocks = system_.blocks_;
  if (weights.position != 0)
    for (const auto& batch : system_.batches_.constraints)
      if (const BatchRange range = batch->part(part); !range.empty())
        batch->add_stiffness(work_, range, blocks, weights.position, lambda.data());
  if (weights.position != 0 || weights.velocity != 0)
    for (const auto& batch : system_.batches_.forces)
      if (const BatchRange range = batch->part(part); !range.empty()) batch->add_tangent(work_, range, blocks, weights);
}

void Evaluator::factorize(const TangentWeights& weights, ConstVectorRef v_dot, ConstVectorRef lambda,
                          const VectorX* increment) {
  factors_->factorize(weights, v_dot, lambda, increment);
}

void Evaluator::solve(VectorRef rv, VectorRef rl) const { factors_->solve(rv, rl); }

void Evaluator::visit_blocks(const std::function<void(int, int, ConstMatrixRef)>& visit) const {
  factors_->visit_blocks(visit);
}

void Evaluator::recall_rows(const std::vector<int>& left_out) {
  if (left_out == facts_.redundant_rows) return;
  if (left_out.empty()) {
    facts_.redundant_rows.clear();
    for (const RedundantRow& r : system_.redundant_) facts_.redundant_rows.push_back(r.row);
  } else {
    facts_.redundant_rows = left_out;
  }
  factors_->drop_rows(facts_.redundant_rows);
}

BodyState Evaluator::body_state(std::size_t place) {
  const auto at = system_.body_places_[place];
  BodyCache* cache = &caches_[at.batch]->at(at.index);
  if (place == 0) return {nullptr, nullptr, cache};
  const auto& slice = system_.layout().bodies()[at.slice];
  return {work_.q.data() + slice.q, work_.v.data() + slice.v, cache};
}

BodyEnergy Evaluator::energy() {
  BodyEnergy sum;
  const auto& bodies = system_.graph().bodies();
  for (std::size_t i = 1; i < bodies.size(); ++i) {
    const BodyEnergy e = bodies[i].body->energy(body_state(i), work_.gravity);
    sum.kinetic += e.kinetic, sum.elastic += e.elastic, sum.gravity += e.gravity;
  }
  sum.elastic += work_.force_energy.sum();
  return sum;
}

}  // namespace lithe
