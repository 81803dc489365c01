#include <algorithm>
#include <map>

#include "engine/assembly/batch_of.h"
#include "engine/assembly/body_check.h"
#include "engine/assembly/evaluator.h"
#include "engine/assembly/find_rigid_scene.h"
#include "engine/assembly/least_norm.h"
#include "engine/assembly/moment_check.h"
#include "engine/assembly/plain_frames.h"
#include "engine/assembly/reached_state.h"
#include "engine/assembly/redundancy.h"
#include "engine/assembly/scene_parts.h"
#include "engine/assembly/system.h"
#include "engine/assembly/tangent_factors.h"
#include "engine/base/error.h"
#include "engine/base/log.h"
#include "engine/base/number_text.h"
#include "engine/model/coupled_markers.h"
#include "engine/model/initial_pose.h"
#include "engine/motion/projection.h"

namespace lithe {

template std::unique_ptr<BodyBatch> make_body_batch<Ground>();

/// Turns a graph into a system, in the order of its functions.
class SystemBuilder {
 public:
  SystemBuilder(SystemGraph& graph, const AssembleOptions& options) : graph_(graph), options_(options) {
    system_.graph_ = &graph;
  }

  System build() {
    if (graph_.bodies().size() < 2)
      throw SceneError("the scene has no body", "assemble", "add one: graph.add<RigidBody>(\"name\", {...})");
    if (options_.threads < 1)
      throw SceneError("assemble is to use " + std::to_string(options_.threads) + " threads", "assemble",
                       "give one or more");
    lay_out();
    gather_markers();
    gather_angles();
    initialize_connectors();
    find_velocity_rows();
    plan_blocks();
    fill_batches();
    count_quarter_turns();
    for (double& quarter_turns : system_.initial_.quarter_turns) quarter_turns = initial::quarter_turns(quarter_turns);
    used_.clear(), drawn_caches_.clear();  // large scenes hold the most memory from here on
    if (options_.start == AssembleOptions::Start::as_drawn) {
      start_without_accelerations();
      return std::move(system_);
    }
    find_redundant_rows();
    make_initial_state();
    if (options_.forward_dynamics) system_.forward_method_ = find_forward_method(system_);
    system_.threads_ = options_.threads;
    report();
    return std::move(system_);
  }

 private:
  struct Used {
    int place;
    MarkerKinematics drawn;
  };

  void lay_out() {
    Layout& layout = system_.layout_;
    for (const auto& b : graph_.bodies())
      if (b.body != &graph_.ground()) layout.add_body(*b.body);
    for (const auto& c : graph_.constraints()) layout.add_rows(c.constraint->name(), c.constraint->row_count());
    q_.setZero(layout.q_count());
    v_.setZero(layout.v_count());
    for (const auto& s : layout.bodies()) {
      if (s.part > 0) continue;
      numbers_.emplace(s.body, static_cast<int>(numbers_.size()));
      first_slices_.push_back(static_cast<int>(&s - layout.bodies().data()));
      const Coordinates c = s.body->coordinates();
      read_initial_state(*s.body, q_.segment(s.q, c.q_count()), v_.segment(s.v, c.v_count()));
    }
  }

  /// Every marker that a connector uses gets a place in the table; its drawn pose tells what it is.
  void gather_markers() {
    const auto use = [&](const Marker& m) {
      const auto [it, fresh] = used_.try_emplace({m.body, m.index}, Used{static_cast<int>(used_.size()), {}});
      if (fresh) it->second.drawn = kinematics(m);
    };
    for (const auto& c : graph_.constraints())
      for (const Marker& m : c.markers) use(m);
    const auto use_all = [&](const auto& entry) {
      for (const Marker& m : entry.markers) use(m);
    };
    graph_.for_each_load(use_all, use_all);
    system_.marker_count_ = static_cast<int>(used_.size());
  }

  /// Measured angles, in the order of constraints, then forces.
  void gather_angles() {
    const auto gather = [&](const Connector& connector, const std::vector<Marker>& markers) {
      system_.first_angles_.push_back(static_cast<int>(system_.angles_.size()));
      for (const MeasuredAngle& a : connector.angles()) {
        const Marker &A = markers[a.A], &B = markers[a.B];
        system_.angles_.push_back(
            {used_.at({A.body, A.index}).place, used_.at({B.body, B.index}).place, a.axis, a.to_point, A, B});
      }
    };
    // Counted from the drawing on, where initialize() measures too: initial::angle() gives half a turn the same sign.
    for (const auto& c : graph_.constraints()) gather(*c.constraint, c.markers);
    for (const auto& f : graph_.forces()) gather(*f.force, f.markers);
    system_.initial_.quarter_turns.setZero(static_cast<int>(system_.angles_.size()));
  }

  /// Angles of q_: as drawn first, then followed onto the constraints.
  void count_quarter_turns() {
    if (system_.angles_.empty()) return;
    Evaluator evaluator(system_);
    evaluator.evaluate(0, q_, v_, Level::position);
    evaluator.track(system_.initial_.quarter_turns);
  }

  void find_velocity_rows() {
    for (std::size_t i = 0; i < graph_.constraints().size(); ++i) {
      const auto& c = graph_.constraints()[i];
      const auto poses = drawn(c.markers);
      ConstraintRows rows(static_cast<int>(poses.size()));
      c.constraint->evaluate(0, connector::Views(poses.data(), static_cast<int>(poses.size())), rows);
      for (int r = 0; r < rows.count(); ++r)
        if (rows.on_velocity(r)) system_.velocity_rows_.push_back(system_.layout_.rows()[i].first + r);
    }
  }

  MarkerKinematics kinematics(const Marker& m) {
    auto& cache = drawn_caches_[m.body];
    static const double none = 0;
    BodyState state{&none, &none, nullptr};
    if (m.body != &graph_.ground()) {
      const auto& slice = slice_of(*m.body);
      state = {q_.data() + slice.q, v_.data() + slice.v, nullptr};
    }
    if (!cache) {
      cache = m.body->make_cache();
      state.cache = cache.get();
      m.body->evaluate(state, Level::velocity);
    }
    state.cache = cache.get();
    MarkerKinematics k;
    m.body->marker_kinematics(state, m.index, Level::velocity, k);
    return k;
  }

  /// The first of the body's.
  const Layout::BodySlice& slice_of(const Body& body) const {
    return system_.layout_.bodies()[first_slices_[numbers_.at(&body)]];
  }

  std::vector<MarkerKinematics> drawn(const std::vector<Marker>& markers) const {
    std::vector<MarkerKinematics> out;
    for (const Marker& m : markers) out.push_back(used_.at({m.body, m.index}).drawn);
    return out;
  }

  void initialize_connectors() {
    for (const auto& c : graph_.constraints()) {
      if (std::all_of(c.markers.begin(), c.markers.end(), [&](const Marker& m) { return m.body == &graph_.ground(); }))
        throw SceneError("'" + c.constraint->name() + "' ties ground to ground", c.constraint->where(),
                         "give at least one marker of a body");
      initialize(*c.constraint, c.markers);
    }
    for (const auto& f : graph_.forces()) initialize(*f.force, f.markers);
  }

  template <class Connector>
  void initialize(Connector& element, const std::vector<Marker>& markers) const {
    if (options_.start == AssembleOptions::Start::as_drawn) return;
    const auto poses = drawn(markers);
    try {
      element.initialize(connector::Views(poses.data(), static_cast<int>(poses.size())));
    } catch (const SceneError& error) {
      throw SceneError("'" + element.name() + "': " + error.problem(), element.where(), error.fix());
    }
    refuse_moments(element, markers, poses);
  }

  void plan_blocks() {
    BlockStructure& b = system_.blocks_;
    const Layout& layout = system_.layout_;
    b.velocity_count = layout.v_count();
    std::vector<std::pair<int, int>> couplings;
    for (int first : first_slices_) {
      const Layout::BodySlice& s = layout.bodies()[first];
      const Coordinates c = s.body->coordinates();
      BodyRecord record{s.q, s.v, -1, -1, c.frames, {}, {}, {}};
      if (s.frame) record.frame = static_cast<int>(b.frames.size());
      for (int i = 0; i < c.frames; ++i) b.frames.push_back({s.v + 6 * i, b.reserve(36)});
      if (c.frames == 1 && c.linear == 0) b.frames.back().plain = rigid_inertia_of(*s.body) != nullptr;
      for (const FramePair& p : c.pairs) couplings.emplace_back(record.frame + p.first, record.frame + p.second);
      if (const int n = c.linear; n > 0) {
        record.linear = static_cast<int>(b.linears.size());
        const LinearPattern* pattern = c.pattern;
        const int coupled = 6 * n * c.frames;
        BlockStructure::Linear linear{s.v + 6 * c.frames, n, record.frame, c.frames, 0, 0, 0, pattern};
        linear.frame_linear = b.reserve(coupled);
        linear.linear_frame = b.reserve(coupled);
        linear.values = b.reserve(pattern ? static_cast<int>(pattern->rows.size()) : n);
        b.linears.push_back(linear);
      }
      records_.push_back(std::move(record));
    }
    for (std::size_t i = 0; i < graph_.constraints().size(); ++i) {
      const auto& c = graph_.constraints()[i];
      const auto& rows = layout.rows()[i];
      ConnectorRecord record = connect(c.markers, rows.first, rows.count, -1, false);
      record.first_angle = system_.first_angles_[i];
      if (connector::couples(*c.constraint, drawn(c.markers))) add_couplings(record, couplings);
      constraint_records_.push_back(record);
    }
    plain_.exclude_by(constraint_records_);
    b.row_count = layout.row_count();
    const auto plan_force = [&](const SystemGraph::ForceEntry& f) {
      const int rows = f.force->row_count();
      const int compliant = rows > 0 ? b.reserve(rows) : -1;
      ConnectorRecord record = connect(f.markers, b.row_count, rows, compliant, true);
      record.energy = f.place;
      record.first_angle = system_.first_angles_[graph_.constraints().size() + force_records_.size()];
      reactions_.push_back(reaction_of(*f.force, record));
      if (record.marker_count <= kMaxMarkers || dynamic_cast<const CoupledMarkers*>(f.force))
        add_couplings(record, couplings);
      plain_.exclude(record);
      force_records_.push_back(record);
      b.row_count += rows;
      system_.compliant_count_ += rows;
    };
    graph_.for_each_load(plan_force, [&](const SystemGraph::ContactEntry& contact) { add_contact(contact); });
    std::sort(couplings.begin(), couplings.end());
    couplings.erase(std::unique(couplings.begin(), couplings.end()), couplings.end());
    for (const auto& [a, c] : couplings) {
      BlockStructure::Coupling coupling{a, c, 0, 0};
      coupling.ab = b.reserve(36);
      coupling.ba = b.reserve(36);
      b.couplings.push_back(coupling);
    }
    for (std::size_t i = 0; i < records_.size(); ++i)
      for (const FramePair& p : layout.bodies()[first_slices_[i]].body->coordinates().pairs) {
        BodyRecord& record = records_[i];
        const std::pair<int, int> frames(record.frame + p.first, record.frame + p.second);
        const auto at = std::lower_bound(couplings.begin(), couplings.end(), frames);
        const auto& coupling = b.couplings[at - couplings.begin()];
        record.pairs.push_back({coupling.ab, coupling.ba});
      }
    plain_.mark(constraint_records_);
  }

  ConnectorRecord connect(const std::vector<Marker>& markers, int first_row, int rows, int compliant, bool loads) {
    BlockStructure& b = system_.blocks_;
    std::vector<MarkerSlot> slots;
    ConnectorRecord record;
    record.first_row = first_row;
    record.rows = -1;
    if (rows > 0) {
      record.rows = static_cast<int>(b.rows.size());
      b.rows.push_back({first_row, rows, compliant});
    }
    record.marker_count = static_cast<int>(markers.size());
    std::map<std::pair<const Body*, int>, int> jacobians;  // by body and frame
    struct Linear {
      int values;  // of the rows by the linear coordinates, in the first Jacobian of the body
      bool written = false;
    };
    std::map<const Body*, Linear> linears;
    const auto moves = [&](const Body* body) {  // any of the markers on it moves with its linear coordinates
      return std::any_of(markers.begin(), markers.end(), [&](const Marker& m) {
        return m.body == body && used_.at({m.body, m.index}).drawn.elastic != nullptr;
      });
    };
    // A slot on one frame, or on none; where the first of a connector's slots on a frame writes its block.
    const auto place = [&](MarkerSlot& slot, const Marker& m, const Used& used, int frame) {
      const auto& s = (&slice_of(*m.body))[frame];
      BodyRecord& body = records_[numbers_.at(m.body)];
      add_once(body.markers, m.index, used.place);
      if (loads) add_once(body.loaded, m.index, used.place);
      slot.velocity = s.v;
      slot.frame = body.frame < 0 ? -1 : body.frame + frame;
      if (used.drawn.elastic) {
        if (used.drawn.between)
          throw SceneError("a marker of body '" + m.body->name() + "' moves with two frames and linear coordinates",
                           m.body->where(), "its author is to fix marker_kinematics(): one or the other");
        slot.linear = body.linear, slot.size = b.linears[body.linear].size, slot.eta = b.linears[body.linear].v;
      }
      if (rows == 0) return;
      const auto [jacobian, fresh] = jacobians.try_emplace({m.body, frame}, static_cast<int>(b.jacobians.size()));
      slot.jacobian = jacobian->second;
      slot.first_frame = fresh;
      if (fresh) {
        BlockStructure::Jacobian G{record.rows, slot.frame, 0, -1, 0, s.v};
        if (slot.frame >= 0) G.values = b.reserve(6 * rows);
        if (moves(m.body)) {
          const auto [linear, first] = linears.try_emplace(m.body, Linear{b.value_count});
          if (first) G.linear = body.linear, b.reserve(rows * b.linears[body.linear].size);
          G.linear_values = linear->second.values;
        }
        b.jacobians.push_back(G);
      }
      if (slot.linear < 0) return;
      Linear& linear = linears.at(m.body);
      slot.first_linear = !linear.written;
      linear.written = true;
    };
    for (int share : {0, 1})
      for (std::size_t i = 0; i < markers.size(); ++i) {
        const Marker& m = markers[i];
        const Used& used = used_.at({m.body, m.index});
        const MarkerBetween* between = used.drawn.between;
        if (share > 0 && !between) continue;
        MarkerSlot slot{used.place, -1, -1, -1, 0, -1, -1, false, false, static_cast<int>(i), between ? share : -1};
        if (m.body != &graph_.ground()) {
          place(slot, m, used, between ? between->shares[share].frame : used.drawn.frame);
        } else {
          add_once(ground_.markers, m.index, used.place);
          if (loads) add_once(ground_.loaded, m.index, used.place);
        }
        slots.push_back(slot);
      }
    record.slot_count = static_cast<int>(slots.size());
    record.slots = keep(slots.data(), record.slot_count);
    return record;
  }

  /// A connector's slots lie side by side in memory that does not move.
  const MarkerSlot* keep(const MarkerSlot* slots, int count) {
    constexpr std::size_t kChunk = 1024;
    auto& chunks = system_.slots_;
    if (chunks.empty() || chunks.back().size() + count > chunks.back().capacity())
      chunks.emplace_back().reserve(std::max<std::size_t>(kChunk, count));
    auto& chunk = chunks.back();
    chunk.insert(chunk.end(), slots, slots + count);
    return chunk.data() + chunk.size() - count;
  }

  void add_contact(const SystemGraph::ContactEntry& entry) {
    const std::vector<Marker>& markers = entry.markers;
    const ConnectorRecord record = connect(markers, system_.blocks_.row_count, 0, -1, true);
    plain_.exclude(record);
    ContactRecord contact{entry.contact, static_cast<int>(system_.contacts_.size()), entry.place, markers, {}, {}};
    for (std::size_t i = 0; i < markers.size(); ++i) {
      contact.places.push_back(record.slots[i].marker);
      const Marker& m = markers[i];
      if (used_.at({m.body, m.index}).drawn.between)
        throw SceneError(
            "'" + entry.contact->name() + "' has a collider on a marker between two frames of '" + m.body->name() + "'",
            entry.contact->where(), "put it on a marker at a node");
      contact.bodies.push_back(m.body == &graph_.ground()
                                   ? -1
                                   : first_slices_[numbers_.at(m.body)] + used_.at({m.body, m.index}).drawn.frame);
    }
    system_.contacts_.push_back(std::move(contact));
  }

  ReactionRecord reaction_of(const ForceElement& force, const ConnectorRecord& record) {
    ReactionRecord reaction{force.reaction_of(), {}, -1};
    if (!reaction.joint) return reaction;
    const auto& joints = graph_.constraints();
    const auto at =
        std::find_if(joints.begin(), joints.end(), [&](const auto& c) { return c.constraint == reaction.joint; });
    if (at == joints.end())
      throw SceneError("'" + force.name() + "' needs the reaction of a joint that is not in this scene", force.where(),
                       "give a joint of the same graph");
    BlockStructure& b = system_.blocks_;
    reaction.record = constraint_records_[at - joints.begin()];
    reaction.coupling = static_cast<int>(b.row_couplings.size());
    b.row_couplings.push_back(
        {record.rows, reaction.record.rows, b.reserve(b.rows[record.rows].count * b.rows[reaction.record.rows].count)});
    system_.reacts_ = true;
    return reaction;
  }

  static void add_once(std::vector<std::pair<int, int>>& markers, int index, int place) {
    if (std::none_of(markers.begin(), markers.end(), [&](const auto& p) { return p.second == place; }))
      markers.emplace_back(index, place);
  }

  static void add_couplings(const ConnectorRecord& record, std::vector<std::pair<int, int>>& couplings) {
    for (int i = 0; i < record.slot_count; ++i)
      for (int j = 0; j < record.slot_count; ++j) {
        const int a = record.slots[i].frame, b = record.slots[j].frame;
        if (a >= 0 && b >= 0 && a < b) couplings.emplace_back(a, b);
      }
  }

  void fill_batches() {
    auto& batches = system_.batches_;
    const auto& bodies = graph_.bodies();
    const auto& constraints = graph_.constraints();
    const auto& forces = graph_.forces();
    const std::vector<int> parts = cut_into_parts(system_.layout_, system_.blocks_, records_, system_.parts_);
    const int between = static_cast<int>(system_.parts_.size());
    const auto part_of = [&](const std::vector<Marker>& markers) {
      return common_part(markers, between,
                         [&](const Body& b) { return &b == &graph_.ground() ? -1 : parts[numbers_.at(&b)]; });
    };
    fill_by_part(
        bodies, batches.bodies, between, [&](const auto&, std::size_t i) { return i == 0 ? 0 : parts[i - 1]; },
        [&](int batch, int index, std::size_t i) {
          batches.bodies[batch]->add(*bodies[i].body, i == 0 ? ground_ : records_[i - 1]);
          system_.body_places_.push_back({batch, index, i == 0 ? -1 : first_slices_[i - 1]});
        });
    fill_by_part(
        constraints, batches.constraints, between,
        [&](const auto&, std::size_t i) { return part_of(constraints[i].markers); },
        [&](int batch, int, std::size_t i) {
          batches.constraints[batch]->add(*constraints[i].constraint, constraint_records_[i]);
        });
    fill_by_part(
        forces, batches.forces, between,
        [&](const ForceBatch& batch, std::size_t i) { return batch.shares() ? part_of(forces[i].markers) : between; },
        [&](int batch, int, std::size_t i) {
          batches.forces[batch]->add(*forces[i].force, force_records_[i], reactions_[i]);
        });
  }

  /// Rows that depend on others a small way from q_, along motions which the rows that are independent at q_ admit.
  std::vector<int> dependent_nearby(double tolerance) {
    constexpr double kMove = 3e-3;  // rad, or m beside the reach of the largest body
    const Layout& layout = system_.layout_;
    Evaluator evaluator(system_);
    VectorX move = VectorX::Zero(v_.size()), force = move, rows = VectorX::Zero(layout.row_count());
    const VectorX still = move, no_load = rows;
    evaluator.evaluate(0, q_, still, Level::velocity);
    double reach = 0;
    for (const MarkerKinematics& marker : evaluator.workspace().markers) reach = std::max(reach, marker.r.norm());
    if (reach == 0) reach = 1;
    // 1. Any motion, and what of it the rows admit: x with M x + Gᵀ y = M move, G x = 0.
    for (const auto& b : layout.bodies())
      if (b.frame)
        for (int i = 0; i < 6; ++i) move[b.v + i] = std::sin(1 + 2.4 * (b.v + i)) * (i < 3 ? reach : 1);
    evaluator.residual(move, no_load, force);
    VectorX load(force.size());
    evaluator.residual(still, no_load, load);
    force -= load;
    const auto dropped = evaluator.factors().find_dependent_rows(tolerance);
    evaluator.solve(force, rows);
    double size = 0;
    for (const auto& b : layout.bodies())
      if (b.frame)
        size = std::max({size, force.segment<3>(b.v).cwiseAbs().maxCoeff() / reach,
                         force.segment<3>(b.v + 3).cwiseAbs().maxCoeff()});
    if (size < 1e-9) return dropped;  // nothing can move
    VectorX q = q_;
    force *= kMove / size;
    layout.retract(q_, force, q);
    // 2. Back onto those rows; what was truly redundant holds there too.
    if (!Projector(evaluator).position(0, q, 1e-10 * (1 + reach), 20).converged) return dropped;
    evaluator.evaluate(0, q, still, Level::velocity);
    evaluator.factors().drop_rows({});
    return evaluator.factors().find_dependent_rows(tolerance);
  }

  void find_redundant_rows() {
    if (system_.layout_.row_count() == 0) return;
    constexpr double kDependent = 1e-9;  // squared sine of the angle to the other rows
    Evaluator evaluator(system_);
    const VectorX still = VectorX::Zero(v_.size()), no_load = VectorX::Zero(system_.layout_.row_count());
    evaluator.evaluate(0, q_, still, Level::velocity);
    const std::vector<double>& values = evaluator.workspace().values;
    const bool tree = is_tree(graph_, system_.layout_);
    if (tree) evaluator.write_tangent({0, 0, 1}, still, no_load, nullptr);
    std::vector<int> dependent = tree ? dependent_within_joints(system_.blocks_, values, kDependent)
                                      : evaluator.factors().find_dependent_rows(kDependent);
    if (tree && !dependent.empty()) {
      evaluator.factors().drop_rows(dependent);
      evaluator.factorize({0, 0, 1}, still, no_load, nullptr);
    } else if (!dependent.empty()) {
      // A pose that is singular by chance looks the same; out of it, its rows are needed.
      const std::vector<int> nearby = dependent_nearby(kDependent);
      if (nearby.size() < dependent.size()) {
        log::warn("the start is a singular position: " + std::to_string(dependent.size() - nearby.size()) +
                  " of its rows lose rank only there\n  fix:  none if the velocities select the branch; "
                  "accelerations at t = 0 are not unique.");
        singular_start_ = true;
        dependent = nearby;
        evaluator.factors().drop_rows(dependent);
        evaluator.factorize({0, 0, 1}, still, no_load, nullptr);
      }
    }
    if (dependent.empty()) return;
    for (int row : dependent) system_.redundant_.push_back({row, system_.layout_.row_name(row), ""});
    system_.row_scales_ = row_compliances(system_.blocks_, values).cwiseSqrt().unaryExpr([](double scale) {
      return scale > 0 ? scale : 1;
    });
    log::warn(dependent_rows_text(graph_, system_.layout_, dependent));
    // Which row each of them repeats: the largest partner in its null vector z, Gᵀ z = 0. A solution each: some only.
    constexpr std::size_t kCompared = 100;
    for (std::size_t k = 0; k < dependent.size(); ++k) {
      RedundantRow& r = system_.redundant_[k];
      if (k >= kCompared) {
        r.repeats = "other rows";
        continue;
      }
      VectorX z = null_vector(evaluator, r.row);
      z[r.row] = 0;
      int partner = 0;
      if (z.cwiseAbs().maxCoeff(&partner) > 1e-8) r.repeats = system_.layout_.row_name(partner);
    }
  }

  void make_initial_state() {
    Evaluator evaluator(system_);
    Projector projector(evaluator);
    const Layout& layout = system_.layout_;
    VectorX g = VectorX::Zero(layout.row_count());
    const auto worst_row = [&] {
      evaluator.evaluate(0, q_, v_, Level::velocity);
      evaluator.constraint(Level::position, g);
      int row = 0;
      g.cwiseAbs().maxCoeff<Eigen::PropagateNaN>(&row);
      return row;
    };
    if (layout.row_count() > 0) {
      const VectorX q_drawn = q_;
      const int drawn_row = worst_row();
      const double drawn_gap = std::abs(g[drawn_row]);
      if (options_.start == AssembleOptions::Start::refuse && drawn_gap > 1e-9)
        throw SceneError(
            "the start is not consistent: " + layout.row_name(drawn_row) + " is off by " + std::to_string(drawn_gap),
            "assemble", "place the bodies so that the joint closes, or let assemble() move them");
      const auto result = projector.position(0, q_, options_.position_tolerance, 60);
      const int row = worst_row();
      if (!(std::abs(g[row]) < 1e-8) && std::ranges::binary_search(evaluator.redundant_rows(), row))
        throw SceneError("cannot be assembled: " + contradiction(evaluator, row) + " is off by " + number_text(g[row]),
                         "assemble", kContradictionFix);
      if (!(std::abs(g[row]) < 1e-8))
        throw SceneError("the joints cannot be assembled: " + layout.row_name(row) + " stays off by " +
                             std::to_string(std::abs(g[row])) + " after " + std::to_string(result.iterations) +
                             " iterations",
                         "assemble", "check lengths and marker positions, or start nearer to a pose that closes");
      VectorX moved(layout.v_count());
      layout.difference(q_drawn, q_, moved);
      int where = 0;
      if (moved.cwiseAbs().maxCoeff(&where) > 1e-6)
        log::warn("bodies were moved onto the constraints, most: " + layout.velocity_name(where) + " by " +
                  std::to_string(moved[where]) + " (" + layout.row_name(drawn_row) + " was off by " +
                  std::to_string(drawn_gap) + ")");
      const VectorX v_drawn = v_;
      projector.velocity(0, q_, v_);
      if ((v_ - v_drawn).cwiseAbs().maxCoeff(&where) > 1e-6 * (1 + v_drawn.cwiseAbs().maxCoeff()))
        log::warn("velocities were made consistent, most: " + layout.velocity_name(where) + " from " +
                  std::to_string(v_drawn[where]) + " to " + std::to_string(v_[where]));
    }
    start_without_accelerations();
    count_quarter_turns();
    evaluator.recall(system_.initial_.quarter_turns);
    projector.accelerations(0, q_, v_, system_.initial_.v_dot, system_.initial_.lambda);
    if (!system_.initial_.v_dot.allFinite())
      throw SceneError("the accelerations at t = 0 are not finite", "assemble",
                       "look for a body without mass or inertia, or a force that divides by a zero distance");
    const auto reached = ReachedState::make(evaluator);
    if (reached && !singular_start_) reached->check_start(system_.initial_);
    minimize_norm(evaluator, system_.initial_.lambda);
  }

  void start_without_accelerations() {
    VectorX& angles = system_.initial_.quarter_turns;
    system_.initial_ = {0, q_, v_, VectorX::Zero(v_.size()), VectorX::Zero(system_.layout_.row_count()), angles};
  }

  void report() const {
    const Layout& l = system_.layout_;
    log::info("assembled: " + std::to_string(l.bodies().size()) + " bodies, " + std::to_string(l.q_count()) +
              " coordinates, " + std::to_string(l.row_count()) + " constraint rows of rank " +
              std::to_string(system_.rank()) + ", " + std::to_string(system_.degrees_of_freedom()) +
              " degrees of freedom" +
              (system_.forward_method_ == ForwardMethod::planar ? ", planar"
               : system_.forward_method_ == ForwardMethod::tree ? ", a rigid tree"
                                                                : ""));
  }

  SystemGraph& graph_;
  AssembleOptions options_;
  System system_;
  VectorX q_, v_;
  std::map<std::pair<const Body*, int>, Used> used_;
  std::map<const Body*, std::unique_ptr<BodyCache>> drawn_caches_;
  std::map<const Body*, int> numbers_;  // of the graph's bodies, without ground
  std::vector<int> first_slices_;       // by number, indices into Layout::bodies()
  std::vector<BodyRecord> records_;     // by number
  BodyRecord ground_{0, 0, -1, -1, 0, {}, {}, {}};
  std::vector<ConnectorRecord> constraint_records_, force_records_;
  std::vector<ReactionRecord> reactions_;
  bool singular_start_ = false;
  PlainFrames plain_{graph_, system_.blocks_};
};

System assemble(SystemGraph& graph, const AssembleOptions& options) try {
  return SystemBuilder(graph, options).build();
} catch (...) {
  rethrow_as_error("assemble", "the scene of " + std::to_string(graph.bodies().size() - 1) + " bodies",
                   "see what it says; the graph can be assembled again");
}

}  // namespace lithe
