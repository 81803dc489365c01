#include "engine/assembly/assembler.h"

#include <algorithm>

#include "engine/assembly/forward_part.h"
#include "engine/assembly/least_norm.h"
#include "engine/base/error.h"
#include "engine/contact/contact_correction.h"
#include "engine/contact/rigid_contacts.h"
#include "engine/factor/block_factor.h"
#include "engine/factor/block_kernels.h"

namespace lithe {
namespace {

constexpr int kMostContactRows = 1200;  // whose couplings are solved for exactly

}  // namespace

/// Of factorize_complex().
struct Assembler::ComplexPart {
  explicit ComplexPart(const BlockStructure& structure) : factor(structure) {}
  ComplexBlockFactor factor;
  std::vector<std::complex<double>> values;
  ComplexVectorX unknowns;
  ContactCorrection<std::complex<double>> contacts;
};

Assembler::Assembler(const System& system) : system_(system), factor_(std::make_unique<BlockFactor>(system.blocks_)) {
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
  unknowns_.setZero(layout.v_count() + rows + compliant);
  zero_v_.setZero(layout.v_count());
  zero_rows_.setZero(rows);
  facts_ = {.layout = &layout,
            .redundant_rows = {},
            .velocity_rows = system.velocity_rows(),
            .reacts = system.reacts_,
            .has_loops = factor_->guarded()};
  for (const RedundantRow& r : system.redundant_) facts_.redundant_rows.push_back(r.row);
  factor_->drop_rows(facts_.redundant_rows);
  if (system.rigid_) forward_ = std::make_unique<ForwardPart>(*system.rigid_, *this);
  if (system.contacts().empty()) return;
  std::vector<BodyState> bodies;
  for (const auto& slice : layout.bodies()) bodies.push_back(body_state(*slice.body));
  contact_correction_ = std::make_unique<ContactCorrection<double>>();
  contacts_ = std::make_unique<ContactForces>(system.contacts(), layout, work_.markers, work_.v, std::move(bodies));
  if (!contacts_->any_rigid()) return;
  std::vector<int> loaded;
  for (const auto& entry : system.graph().forces())
    for (const Marker& m : entry.markers)
      if (const int first = find_body(*m.body); first >= 0)
        for (int i = 0; i < std::max(1, m.body->coordinates().frames); ++i) loaded.push_back(first + i);
  rigid_contacts_ = std::make_unique<RigidContacts>(RigidContacts::Scene{
      *this, system.blocks_, work_.values, system.contacts(), *contacts_, std::move(loaded), system.gravity().norm()});
}

void Assembler::recall(const ContactMemory& contacts) {
  if (contacts_) contacts_->recall(contacts);
}

EquationsOfMotion::Parts Assembler::parts() {
  return {.memory = this,
          .complex_factor = this,
          .forward_dynamics = forward_.get(),
          .rigid_contacts = rigid_contacts_.get(),
          .held = this};
}

void Assembler::track_contacts(State& state) {
  if (!contacts_ || !contacts_->remembers()) return;
  evaluate(state.time, state.q, state.v, Level::velocity);
  contacts_->track(state.contacts);
}

/// Here, where the parts are complete types.
Assembler::~Assembler() = default;

const double* Assembler::applied_forces(double time, ConstVectorRef q, ConstVectorRef v) {
  if (!has_forces()) return nullptr;
  work_.time = time;
  work_.q = q;
  work_.v = v;
  for (std::size_t b = 0; b < caches_.size(); ++b)
    system_.batches_.bodies[b]->evaluate_loaded(work_, *caches_[b], Level::velocity);
  add_applied_forces();
  if (work_.tension.size() > 0) {
    work_.tension = -work_.tension;
    add_row_forces(nullptr, work_.tension.data(), work_.load.data());
    work_.tension = -work_.tension;
  }
  return work_.load.data();
}

/// Loads, tensions and contacts of the state whose markers are evaluated.
void Assembler::add_applied_forces() {
  work_.load.setZero();
  for (const auto& batch : system_.batches_.forces) batch->evaluate(work_, system_.blocks_);
  if (contacts_) contacts_->evaluate(work_.load, work_.force_energy);
}

void Assembler::place_measured_angles(ConstVectorRef q) {
  if (system_.angles_.empty()) return;
  work_.q = q;
  for (std::size_t b = 0; b < caches_.size(); ++b)
    system_.batches_.bodies[b]->evaluate(work_, *caches_[b], Level::position, Level::position);
}

void Assembler::recall(const VectorX& quarter_turns) {
  if (quarter_turns.size() == work_.quarter_turns.size()) work_.quarter_turns = quarter_turns;
}

/// The quarter turns in which (cos, sin) lies, as a number that grows with the angle: exact at every quarter turn and
/// never far off between, at the price of a division. With it the turn count needs no arc tangent a step.
void Assembler::track(VectorX& quarter_turns) const {
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

const double* Assembler::quarter_turns_of(const Connector& connector) const {
  const SystemGraph& graph = system_.graph();
  std::size_t i = 0;
  while (i < graph.constraints().size() && graph.constraints()[i].constraint != &connector) ++i;
  if (i == graph.constraints().size())
    while (i - graph.constraints().size() < graph.forces().size() &&
           graph.forces()[i - graph.constraints().size()].force != &connector)
      ++i;
  return work_.quarter_turns.data() + system_.first_angles_.at(i);
}

int Assembler::find_angle(const JointCoordinate& x) const {
  for (std::size_t i = 0; i < system_.angles_.size(); ++i) {
    const System::Angle& a = system_.angles_[i];
    if (a.of_A == x.A && a.of_B == x.B && a.axis == x.axis && a.to_point == (x.kind == JointCoordinate::Kind::bearing))
      return static_cast<int>(i);
  }
  return -1;
}

void Assembler::react(ConstVectorRef lambda) {
  if (!system_.reacts_) return;
  for (const auto& batch : system_.batches_.forces) batch->react(work_, system_.blocks_, lambda.data());
}

void Assembler::evaluate(double time, ConstVectorRef q, ConstVectorRef v, Level level) {
  work_.time = time;
  work_.q = q;
  work_.v = v;
  // Joints ask for the velocities of markers where the velocity terms of g̈ or rows on velocities are wanted.
  const bool no_velocities = level == Level::velocity && !has_forces() && system_.velocity_rows_.empty();
  const Level markers = no_velocities ? Level::position : level;
  for (std::size_t b = 0; b < caches_.size(); ++b)
    system_.batches_.bodies[b]->evaluate(work_, *caches_[b], level, markers);
  for (const auto& batch : system_.batches_.constraints) batch->evaluate(work_, system_.blocks_, level);
  if (level != Level::position && has_forces()) add_applied_forces();
  if (!held_.velocities.empty()) release_from_joints();
}

bool Assembler::hold(const std::vector<int>& velocities) {
  const auto& blocks = system_.blocks_;
  const auto find_linear = [&](int velocity) {
    return std::find_if(blocks.linears.begin(), blocks.linears.end(),
                        [&](const auto& L) { return velocity >= L.v && velocity < L.v + L.size; });
  };
  for (int velocity : velocities)
    if (find_linear(velocity) == blocks.linears.end()) return false;
  held_.velocities = velocities;
  held_.jacobian.clear(), held_.couplings.clear(), held_.diagonals.clear();
  for (int velocity : velocities) {
    const auto L = find_linear(velocity);
    const int k = velocity - L->v, linear = static_cast<int>(L - blocks.linears.begin());
    for (int i = 0; i < 6 && L->frame >= 0; ++i) {
      held_.couplings.push_back(L->frame_linear + 6 * k + i);
      held_.couplings.push_back(L->linear_frame + k + L->size * i);
    }
    if (!L->pattern) held_.diagonals.push_back(L->values + k);
    for (int entry = 0; L->pattern && entry < L->pattern->rows.size(); ++entry) {
      const int row = L->pattern->rows[entry], column = L->pattern->columns[entry];
      if (row != k && column != k) continue;
      (row == column ? held_.diagonals : held_.couplings).push_back(L->values + entry);
    }
    for (const auto& G : blocks.jacobians) {
      if (G.linear != linear) continue;
      const int rows = blocks.rows[G.rows].count;
      held_.jacobian.emplace_back(G.linear_values + rows * k, rows);
    }
  }
  release_from_joints();
  return true;
}

/// Columns of G of what is held.
void Assembler::release_from_joints() {
  for (const auto& [first, count] : held_.jacobian) std::fill_n(work_.values.data() + first, count, 0.0);
  if (contacts_) contacts_->release(held_.velocities);
}

void Assembler::residual(ConstVectorRef v_dot, ConstVectorRef lambda, VectorRef r) {
  if (!has_forces())
    r.setZero();
  else
    r = -work_.load;
  for (std::size_t b = 0; b < caches_.size(); ++b)
    system_.batches_.bodies[b]->add_residual(work_, *caches_[b], v_dot.data(), r.data());
  react(lambda);
  add_row_forces(lambda.data(), work_.tension.data(), r.data());
  for (int velocity : held_.velocities) r[velocity] = v_dot[velocity];
}

void Assembler::add_row_forces(const double* lambda, const double* tension, double* r) const {
  const auto& blocks = system_.blocks_;
  const int rows = static_cast<int>(work_.residual.size());
  for (const auto& G : blocks.jacobians) {
    const auto& row = blocks.rows[G.rows];
    if (row.first >= rows ? !tension : !lambda) continue;
    const double* y = row.first < rows ? lambda + row.first : tension + row.first - rows;
    double* to = r + G.velocity;
    if (G.frame >= 0) {
      kernels::add_transposed(to, work_.values.data() + G.values, y, row.count, 6);
      to += 6;
    }
    if (G.linear >= 0)
      kernels::add_transposed(to, work_.values.data() + G.linear_values, y, row.count, blocks.linears[G.linear].size);
  }
}

void Assembler::constraint(Level which, VectorRef out) const {
  if (which == Level::position) {
    out = work_.residual;
    return;
  }
  if (which == Level::acceleration) {
    out = -work_.bias;
    return;
  }
  out = work_.rate;
  add_rates(work_.v.data(), out);
}

void Assembler::add_rates(const double* v, VectorRef rates) const {
  const auto& blocks = system_.blocks_;
  for (const auto& G : blocks.jacobians) {
    const auto& row = blocks.rows[G.rows];
    if (row.first >= rates.size()) continue;  // compliant
    double* to = rates.data() + row.first;
    const double* from = v + G.velocity;
    const auto add = [&](const double* values, int columns) {
      for (int c = 0; c < columns; ++c)
        for (int i = 0; i < row.count; ++i) to[i] += values[i + row.count * c] * from[c];
      from += columns;
    };
    if (G.frame >= 0) add(work_.values.data() + G.values, 6);
    if (G.linear >= 0) add(work_.values.data() + G.linear_values, blocks.linears[G.linear].size);
  }
}

void Assembler::form(const TangentWeights& weights, ConstVectorRef v_dot, ConstVectorRef lambda,
                     const VectorX* increment) {
  const auto& blocks = system_.blocks_;
  double* values = work_.values.data();
  for (const auto& c : blocks.couplings) std::fill_n(values + c.ab, 36, 0.0), std::fill_n(values + c.ba, 36, 0.0);
  for (std::size_t b = 0; b < caches_.size(); ++b)
    system_.batches_.bodies[b]->write_tangent(work_, *caches_[b], blocks, v_dot.data(), weights,
                                              increment ? increment->data() : nullptr);
  if (weights.position != 0) {
    for (const auto& batch : system_.batches_.constraints)
      batch->add_stiffness(work_, blocks, weights.position, lambda.data());
  }
  if (weights.position != 0 || weights.velocity != 0)
    for (const auto& batch : system_.batches_.forces) batch->add_tangent(work_, blocks, weights);
  const int rows = static_cast<int>(work_.residual.size());
  for (const auto& row : blocks.rows) {
    if (row.compliant < 0) continue;
    for (int i = 0; i < row.count; ++i) {
      const int k = row.first - rows + i;
      const double stiffness = weights.position * work_.row_stiffness[k] + weights.velocity * work_.row_damping[k];
      values[row.compliant + i] = stiffness == 0 ? -1e30 : -1 / stiffness;  // no stiffness: the row gives way
    }
  }
  if (system_.reacts_)
    for (const auto& batch : system_.batches_.forces) batch->write_reaction_tangent(work_, blocks, lambda.data());
  for (int entry : held_.couplings) values[entry] = 0;
  for (int entry : held_.diagonals) values[entry] = weights.acceleration;
}

/// Of very many contacts, what they are to each body by itself: Newton converges more slowly, at linear cost.
void Assembler::add_contact_diagonals(const TangentWeights& weights) {
  const auto& frames = system_.blocks_.frames;
  int at = 0;
  for (const ContactRows::Row& row : contacts_->rows().points()) {
    const int n = row.rows;
    const Eigen::Map<const MatrixX> by_x(contacts_->by_position().data() + at, n, n),
        by_u(contacts_->by_velocity().data() + at, n, n);
    at += n * n;
    for (const ContactRows::Side& side : row.sides) {
      if (side.frames == 0) continue;
      auto frame = std::lower_bound(frames.begin(), frames.end(), side.velocity,
                                    [](const auto& f, int velocity) { return f.v < velocity; });
      for (int k = 0; k < side.frames; ++k, ++frame) {
        const Eigen::Map<const MatrixX> H(contacts_->rows().values(side) + 6 * n * k, n, 6),
            H_right(contacts_->right().data() + side.H + 6 * n * k, n, 6);
        Eigen::Map<Matrix6>(work_.values.data() + frame->values).noalias() -=
            H.transpose() * (weights.position * by_x + weights.velocity * by_u) * H_right;
      }
    }
  }
}

void Assembler::factorize(const TangentWeights& weights, ConstVectorRef v_dot, ConstVectorRef lambda,
                          const VectorX* increment) {
  form(weights, v_dot, lambda, increment);
  if (contact_correction_) contact_correction_->clear();
  const bool stiff = contacts_ && (weights.position != 0 || weights.velocity != 0);
  if (stiff) contacts_->form(weights, increment);
  const bool many = stiff && contacts_->stiff_rows() > kMostContactRows;
  if (many) add_contact_diagonals(weights);
  factor_->factorize(work_.values);
  if (!factor_->weak_rows().empty()) exchange_weak_rows();
  if (!stiff || many) return;
  contact_correction_->form(*contacts_, weights.position, weights.velocity, static_cast<int>(unknowns_.size()),
                            [&](double* x) { factor_->solve(x); });
}

/// A kept row e that comes to depend on the other kept ones must be left out instead of a row d that no longer depends
/// on them. The motion x with G x = 0 in all kept rows but e, where it is 1, tells: g_d = a g_e + (other kept rows)
/// with a = g_d x, so that the volume that the kept rows span grows by |a|, in rows of equal compliance.
void Assembler::exchange_weak_rows() {
  constexpr double kGain = 2;  // less is not worth a new factor, nor going back and forth
  const int velocities = layout().v_count(), rows = layout().row_count();
  for (int exchanges = 0; exchanges < static_cast<int>(facts_.redundant_rows.size()); ++exchanges) {
    int weakest = -1, stronger = -1;
    double gain = kGain;
    for (int e : factor_->weak_rows()) {
      unknowns_.setZero();
      unknowns_[velocities + e] = 1;
      factor_->solve(unknowns_.data());
      weak_rates_.setZero(rows);
      add_rates(unknowns_.data(), weak_rates_);
      for (std::size_t k = 0; k < facts_.redundant_rows.size(); ++k) {
        const int d = facts_.redundant_rows[k];
        const double a = std::abs(weak_rates_[d] / weak_rates_[e]) * system_.row_scales_[e] / system_.row_scales_[d];
        if (a > gain) gain = a, weakest = e, stronger = static_cast<int>(k);
      }
    }
    if (weakest < 0) break;
    facts_.redundant_rows[stronger] = weakest;
    std::sort(facts_.redundant_rows.begin(), facts_.redundant_rows.end());
    factor_->drop_rows(facts_.redundant_rows);
    factor_->factorize(work_.values);
  }
}

void Assembler::recall_rows(const std::vector<int>& left_out) {
  if (left_out == facts_.redundant_rows) return;
  if (left_out.empty()) {
    facts_.redundant_rows.clear();
    for (const RedundantRow& r : system_.redundant_) facts_.redundant_rows.push_back(r.row);
  } else {
    facts_.redundant_rows = left_out;
  }
  factor_->drop_rows(facts_.redundant_rows);
}

/// S is linear in the weights: twice the real form gives its real and imaginary part. Compliant rows are not: -1/(k w).
void Assembler::factorize_complex(const ComplexTangentWeights& weights, ConstVectorRef v_dot, ConstVectorRef lambda,
                                  const VectorX* increment) {
  const auto& blocks = system_.blocks_;
  if (!complex_) {
    complex_ = std::make_unique<ComplexPart>(blocks);
    complex_->unknowns.setZero(unknowns_.size());
    complex_->values.resize(work_.values.size());
  }
  auto& values = complex_->values;
  form({weights.position.imag(), weights.velocity.imag(), weights.acceleration.imag()}, v_dot, lambda, increment);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = {0, work_.values[i]};
  form({weights.position.real(), weights.velocity.real(), weights.acceleration.real()}, v_dot, lambda, increment);
  for (std::size_t i = 0; i < values.size(); ++i) values[i].real(work_.values[i]);
  // What no weight touches is real: G, and the share of a compliant row's tension in a joint's multipliers.
  const auto make_real = [&](int first, int count) {
    for (int i = first; i < first + count; ++i) values[i].imag(0);
  };
  for (const auto& G : blocks.jacobians) {
    const int rows = blocks.rows[G.rows].count;
    if (G.frame >= 0) make_real(G.values, 6 * rows);
    if (G.linear >= 0) make_real(G.linear_values, blocks.linears[G.linear].size * rows);
  }
  const int rows = static_cast<int>(work_.residual.size());
  for (const auto& row : blocks.rows) {
    if (row.compliant < 0) continue;
    for (int i = 0; i < row.count; ++i) {
      const int k = row.first - rows + i;
      const std::complex<double> stiffness =
          weights.position * work_.row_stiffness[k] + weights.velocity * work_.row_damping[k];
      values[row.compliant + i] = stiffness == 0.0 ? -1e30 : -1.0 / stiffness;
    }
  }
  for (const auto& c : blocks.row_couplings) {
    const auto& row = blocks.rows[c.rows];
    for (int i = 0; i < row.count * blocks.rows[c.on].count; ++i) {
      const int k = row.compliant + i % row.count;
      // As form() left it, over the real compliance; now over the complex one.
      values[c.values + i] = work_.values[c.values + i] / work_.values[k] * values[k];
    }
  }
  complex_->factor.drop_rows(facts_.redundant_rows);
  complex_->factor.factorize(values);
  complex_->contacts.clear();
  if (!contacts_) return;
  contacts_->form({1, 1, 1}, increment);
  complex_->contacts.form(*contacts_, weights.position, weights.velocity, static_cast<int>(unknowns_.size()),
                          [&](std::complex<double>* x) { complex_->factor.solve(x); });
}

void Assembler::solve_complex(ComplexVectorRef rv, ComplexVectorRef rl) const {
  ComplexVectorX& unknowns = complex_->unknowns;
  unknowns.head(rv.size()) = rv;
  unknowns.segment(rv.size(), rl.size()) = rl;
  unknowns.tail(unknowns.size() - rv.size() - rl.size()).setZero();
  complex_->factor.solve(unknowns.data());
  complex_->contacts.apply(unknowns.data());
  rv = unknowns.head(rv.size());
  rl = unknowns.segment(rv.size(), rl.size());
}

void Assembler::solve(VectorRef rv, VectorRef rl) const {
  unknowns_.head(rv.size()) = rv;
  unknowns_.segment(rv.size(), rl.size()) = rl;
  unknowns_.tail(unknowns_.size() - rv.size() - rl.size()).setZero();
  factor_->solve(unknowns_.data());
  if (contact_correction_) contact_correction_->apply(unknowns_.data());
  rv = unknowns_.head(rv.size());
  rl = unknowns_.segment(rv.size(), rl.size());
}

void Assembler::visit_blocks(const std::function<void(int, int, ConstMatrixRef)>& visit) const {
  const auto& b = system_.blocks_;
  const double* values = work_.values.data();
  using View = Eigen::Map<const MatrixX>;
  for (const auto& f : b.frames) visit(f.v, f.v, View(values + f.values, 6, 6));
  for (const auto& l : b.linears) {
    if (l.frame >= 0) {
      visit(b.frames[l.frame].v, l.v, View(values + l.frame_linear, 6, l.size));
      visit(l.v, b.frames[l.frame].v, View(values + l.linear_frame, l.size, 6));
    }
    if (!l.pattern) {
      for (int i = 0; i < l.size; ++i) visit(l.v + i, l.v + i, View(values + l.values + i, 1, 1));
    } else {
      for (int k = 0; k < l.pattern->rows.size(); ++k) {
        const int r = l.pattern->rows[k], c = l.pattern->columns[k];
        visit(l.v + r, l.v + c, View(values + l.values + k, 1, 1));
        if (r != c) visit(l.v + c, l.v + r, View(values + l.values + k, 1, 1));
      }
    }
  }
  for (const auto& c : b.couplings) {
    visit(b.frames[c.a].v, b.frames[c.b].v, View(values + c.ab, 6, 6));
    visit(b.frames[c.b].v, b.frames[c.a].v, View(values + c.ba, 6, 6));
  }
  for (const auto& G : b.jacobians) {
    const auto& row = b.rows[G.rows];
    const auto both = [&](int v, const MatrixX& block) {
      visit(b.velocity_count + row.first, v, block);
      visit(v, b.velocity_count + row.first, block.transpose());
    };
    if (G.frame >= 0) both(G.velocity, View(values + G.values, row.count, 6));
    if (G.linear >= 0) both(b.linears[G.linear].v, View(values + G.linear_values, row.count, b.linears[G.linear].size));
  }
  for (const auto& c : b.row_couplings)
    visit(b.velocity_count + b.rows[c.rows].first, b.velocity_count + b.rows[c.on].first,
          View(values + c.values, b.rows[c.rows].count, b.rows[c.on].count));
  if (contact_correction_ && contact_correction_->active())
    contact_correction_->visit([&](int row, int column, const MatrixX& block) { visit(row, column, block); });
  for (const auto& row : b.rows)
    for (int i = 0; row.compliant >= 0 && i < row.count; ++i)
      visit(b.velocity_count + row.first + i, b.velocity_count + row.first + i, View(values + row.compliant + i, 1, 1));
}

int Assembler::find_body(const Body& body) const {
  const auto& bodies = system_.layout().bodies();
  for (std::size_t i = 0; i < bodies.size(); ++i)
    if (bodies[i].body == &body) return static_cast<int>(i);
  return -1;
}

BodyState Assembler::body_state(const Body& body) {
  const auto& bodies = system_.graph().bodies();
  for (std::size_t i = 0; i < bodies.size(); ++i)
    if (bodies[i].body == &body) return body_state_at(i);
  throw SceneError("body '" + body.name() + "' is not in this system", body.where(),
                   "use a body of the assembled graph");
}

BodyState Assembler::body_state_at(std::size_t place) {
  const auto at = system_.body_places_[place];
  BodyCache* cache = &caches_[at.batch]->at(at.index);
  if (place == 0) return {nullptr, nullptr, cache};
  const auto& slice = system_.layout().bodies()[at.slice];
  return {work_.q.data() + slice.q, work_.v.data() + slice.v, cache};
}

MarkerKinematics Assembler::marker(Marker m, Level level) {
  MarkerKinematics k;
  m.body->marker_kinematics(body_state(*m.body), m.index, level, k);
  return k;
}

BodyEnergy Assembler::energy() {
  BodyEnergy sum;
  const auto& bodies = system_.graph().bodies();
  for (std::size_t i = 1; i < bodies.size(); ++i) {
    const BodyEnergy e = bodies[i].body->energy(body_state(*bodies[i].body), work_.gravity);
    sum.kinetic += e.kinetic, sum.elastic += e.elastic, sum.gravity += e.gravity;
  }
  sum.elastic += work_.force_energy.sum();
  return sum;
}

void Assembler::minimum_norm(VectorRef lambda) {
  if (facts_.redundant_rows.empty()) return;
  if (!least_norm_) least_norm_ = std::make_unique<LeastNorm>(system_.blocks_);
  least_norm_->apply(work_.values, lambda);
}

}  // namespace lithe
