#include "engine/study/model_error.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/assembly/evaluated.h"
#include "engine/model/rigid_frame_body.h"
#include "engine/observe/snapshot.h"
#include "engine/study/driven_oscillators.h"

namespace lithe {
namespace {

constexpr double kFollows = 0.05;  // of a motion, that joints do not let it make
constexpr double kIdle = 1e-8;     // of the root of the strain energy: a coordinate with less has no effect

/// Where the coordinates of one system are in a richer one.
class Embedding {
 public:
  Embedding(const BodyModels& bodies, const ModelRun& run, const std::vector<Fidelity>& richer, const Layout& layout)
      : run_(run), layout_(layout) {
    for (std::size_t i = 0; i < run.slices.size(); ++i) {
      const Layout::BodySlice& to = layout.bodies()[i];
      const auto at = std::find(bodies.bodies().begin(), bodies.bodies().end(), to.body);
      linear_.emplace_back();
      if (at == bodies.bodies().end()) {
        for (int k = 0; k < to.linear; ++k) linear_.back().push_back(k);
        continue;
      }
      const auto b = static_cast<std::size_t>(at - bodies.bodies().begin());
      for (int mode : run.models[b].modes) {
        const auto& modes = richer[b].modes;
        linear_.back().push_back(static_cast<int>(std::find(modes.begin(), modes.end(), mode) - modes.begin()));
      }
      for (std::size_t k = 0; k < richer[b].modes.size(); ++k) {
        const auto& known = run.models[b].modes;
        const bool fresh = std::find(known.begin(), known.end(), richer[b].modes[k]) == known.end();
        elastic_.push_back({static_cast<int>(b), richer[b].modes[k], to.v + (to.frame ? 6 : 0) + static_cast<int>(k),
                            to.q + (to.frame ? 7 : 0) + static_cast<int>(k), fresh});
      }
    }
  }

  struct Elastic {
    int body, mode, v, q;
    bool fresh;  // the run does not have it
  };
  const std::vector<Elastic>& elastic() const { return elastic_; }

  /// The run's velocities (or accelerations) in the richer layout; fresh coordinates zero.
  void velocities(const VectorX& from, VectorX& to) const {
    to.setZero(layout_.v_count());
    for_each([&](const Layout::BodySlice& a, const Layout::BodySlice& b, const std::vector<int>& linear) {
      if (a.frame) to.segment<6>(b.v) = from.segment<6>(a.v);
      const int first = a.frame ? 6 : 0;
      for (std::size_t k = 0; k < linear.size(); ++k)
        to[b.v + first + linear[k]] = from[a.v + first + static_cast<int>(k)];
    });
  }
  void coordinates(const VectorX& from, VectorX& to) const {
    to.setZero(layout_.q_count());
    for_each([&](const Layout::BodySlice& a, const Layout::BodySlice& b, const std::vector<int>& linear) {
      if (a.frame) to.segment<7>(b.q) = from.segment<7>(a.q);
      const int first = a.frame ? 7 : 0;
      for (std::size_t k = 0; k < linear.size(); ++k)
        to[b.q + first + linear[k]] = from[a.q + first + static_cast<int>(k)];
    });
  }

 private:
  template <class Action>
  void for_each(Action action) const {
    for (std::size_t i = 0; i < linear_.size(); ++i) action(run_.slices[i], layout_.bodies()[i], linear_[i]);
  }

  const ModelRun& run_;
  const Layout& layout_;
  std::vector<std::vector<int>> linear_;  // of each body, the place of each linear coordinate of the run
  std::vector<Elastic> elastic_;
};

class Estimate {
 public:
  Estimate(const System& system, const BodyModels& bodies, const ModelRun& run, const std::vector<Fidelity>& richer,
           const std::vector<Sensor>& sensors, int stride, Detail detail)
      : system_(system),
        bodies_(bodies),
        run_(run),
        sensors_(sensors),
        stride_(stride),
        detail_(detail),
        embedding_(bodies, run, richer, system.layout()),
        equations_(system),
        snapshot_(system),
        zero_v_(VectorX::Zero(system.layout().v_count())),
        zero_rows_(VectorX::Zero(system.layout().row_count())) {
    elastic_ = embedding_.elastic();
    choose_markers();
  }

  ModelError make() {
    const auto n = static_cast<Eigen::Index>(elastic_.size()), samples = static_cast<Eigen::Index>(run_.states.size());
    ModelError error;
    error.samples.columns = run_.samples.columns;
    error.effect.assign(sensors_.size(), 0);
    error.samples.values = run_.samples.values;
    if (samples < 2 || n == 0) return error;
    error.samples.values.clear();
    embed();
    VectorX damping, stiffness;
    properties(damping, stiffness);
    const DrivenOscillators oscillators(mobility(), damping, stiffness);
    MatrixX accelerations(n, samples);
    for (Eigen::Index k = 0; k < samples; ++k) drive(k, oscillators, accelerations.col(k));
    const State& initial = system_.initial_state();
    VectorX start(n), start_rate(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const auto& e = elastic_[static_cast<size_t>(i)];
      start[i] = initial.q[e.q] - embedded_.front().q[e.q], start_rate[i] = initial.v[e.v] - embedded_.front().v[e.v];
    }
    const double interval = run_.states[1].time - run_.states[0].time;
    inertia_ = oscillators.inertia();
    error.response = oscillators.respond(accelerations, interval, start, start_rate);
    const auto& response = error.response;

    if (detail_ == Detail::whole) look_at_all(interval, error);
    for (Eigen::Index i = 0; i < n; ++i)
      if (elastic_[static_cast<size_t>(i)].fresh)
        error.coordinates.push_back(
            look_at(i, std::sqrt(stiffness[i]), largest_energy_root(response, stiffness), error));
    return error;
  }

 private:
  /// All together, at every sample.
  void look_at_all(double interval, ModelError& error) {
    std::vector<double> row(error.samples.columns.size());
    const auto samples = static_cast<Eigen::Index>(run_.states.size()), looks = (samples - 1) / stride_ + 1;
    for (const Marker& marker : loaded_)
      error.feedback.push_back({interval * stride_, Matrix3X::Zero(3, looks), Matrix3X::Zero(3, looks), marker});
    for (Eigen::Index k = 0; k < samples; k += stride_) {
      error.states.push_back(moved(k, error.response));
      record_feedback(error.states.back(), k, error.feedback);
      read(error.states.back(), row);
      row[0] = error.states.back().time;
      error.samples.add_row(row);
    }
    const Table base = all_linear() ? run_.samples : unmoved();
    error.effect = sample_differences(sensors_, error.samples, base);
  }
  /// One coordinate, of this root of its stiffness, where it is largest.
  ModelError::Coordinate look_at(Eigen::Index i, double root, double energy_root, const ModelError& error) {
    const auto& e = elastic_[static_cast<size_t>(i)];
    const auto& response = error.response;
    Eigen::Index k = 0;
    const double amplitude = response.displacement.row(i).cwiseAbs().maxCoeff(&k);
    ModelError::Coordinate coordinate{e.body, e.mode, root / (2 * std::numbers::pi), amplitude,
                                      std::vector<double>(sensors_.size(), 0)};
    if (amplitude == 0 || root * amplitude < kIdle * energy_root) return coordinate;
    if (detail_ == Detail::whole) {
      for (std::size_t w = 0; w < sensors_.size(); ++w)
        coordinate.effect[w] = root * amplitude / energy_root * error.effect[w];
      return coordinate;
    }
    const auto alone = [&](const MatrixX& of) {
      return VectorX(VectorX::Unit(static_cast<Eigen::Index>(elastic_.size()), i) * of(i, k));
    };
    joints_hold_ = true;
    const State with = moved(k, alone(response.displacement), alone(response.rate), alone(response.acceleration));
    // Where joints let it move with others only, all of them.
    const State moves = joints_hold_ ? with : moved(k, response);
    const double part = joints_hold_ ? 1 : root * amplitude / energy_root;
    Table one{run_.samples.columns, {}}, there{run_.samples.columns, {}};
    std::vector<double> row(one.columns.size());
    read(moves, row);
    one.add_row(row);
    read(embedded_[static_cast<std::size_t>(k)], row);
    there.add_row(row);
    coordinate.effect = sample_differences(sensors_, one, there);
    for (double& effect : coordinate.effect) effect *= part;
    return coordinate;
  }
  bool all_linear() const {
    return std::all_of(run_.models.begin(), run_.models.end(),
                       [](const Fidelity& m) { return m.modes.empty() || m.deflection == Deflection::linear; });
  }
  /// The sensors at the states of the run as the richer model shows them.
  Table unmoved() {
    Table table{run_.samples.columns, {}};
    std::vector<double> row(table.columns.size());
    for (const State& state : embedded_) {
      read(state, row);
      row[0] = state.time;
      table.add_row(row);
    }
    return table;
  }
  /// √(2 V) of all coordinates where it is largest.
  static double largest_energy_root(const DrivenOscillators::Response& response, const VectorX& stiffness) {
    return std::sqrt((stiffness.transpose() * response.displacement.cwiseAbs2()).maxCoeff());
  }

  /// Where feedback acts: on the frames of deformable bodies, on others at any marker that moves with their frame.
  void choose_markers() {
    for (DeformableBody* body : bodies_.bodies()) loaded_.push_back(body->body_frame());
    const SystemGraph& graph = system_.graph();
    const auto add = [&](const std::vector<Marker>& markers) {
      for (const Marker& m : markers)
        if (rigid_inertia_of(*m.body) &&
            std::none_of(loaded_.begin(), loaded_.end(), [&](const Marker& known) { return known.body == m.body; }))
          loaded_.push_back(m);
    };
    for (const auto& c : graph.constraints()) add(c.markers);
    const auto add_of = [&](const auto& entry) { add(entry.markers); };
    graph.for_each_load(add_of, add_of);
  }

  void embed() {
    if (embedded_.empty())
      for (const State& state : run_.states) embedded_.push_back(embedded(state));
  }

  void properties(VectorX& damping, VectorX& stiffness) const {
    const auto n = static_cast<Eigen::Index>(elastic_.size());
    damping.resize(n), stiffness.resize(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const auto& e = elastic_[static_cast<size_t>(i)];
      const DeformableBody& body = *bodies_.bodies()[static_cast<size_t>(e.body)];
      damping[i] = body.candidate_damping()[e.mode], stiffness[i] = body.candidate_stiffness()[e.mode];
    }
  }

  State embedded(const State& state) {
    State out;
    out.time = state.time;
    embedding_.coordinates(state.q, out.q);
    embedding_.velocities(state.v, out.v);
    embedding_.velocities(state.v_dot, out.v_dot);
    out.lambda = state.lambda;
    out.quarter_turns = state.quarter_turns;
    return out;
  }

  /// Elastic block of the inverse of [M Gᵀ; G 0], halfway through the run.
  MatrixX mobility() {
    const auto n = static_cast<Eigen::Index>(elastic_.size());
    factorize(embedded_[embedded_.size() / 2]);
    MatrixX A(n, n);
    for (Eigen::Index i = 0; i < n; ++i) {
      VectorX x = VectorX::Unit(zero_v_.size(), elastic_[static_cast<size_t>(i)].v), y = zero_rows_;
      equations_.solve(x, y);
      for (Eigen::Index j = 0; j < n; ++j) A(j, i) = x[elastic_[static_cast<size_t>(j)].v];
    }
    return A;
  }

  void factorize(const State& state) {
    equations_.recall(state.quarter_turns);
    equations_.evaluate(state.time, state.q, state.v, Level::acceleration);
    equations_.factorize({0, 0, 1}, state.v_dot, state.lambda, nullptr);
  }

  /// The accelerations that what is left over of the equations gives the elastic coordinates.
  void drive(Eigen::Index sample, const DrivenOscillators& oscillators, Eigen::Ref<VectorX> out) {
    const State& state = embedded_[static_cast<size_t>(sample)];
    VectorX r(zero_v_.size());
    leave_over(state, r);
    VectorX forces(out.size());
    for (Eigen::Index i = 0; i < out.size(); ++i) {
      const auto& e = elastic_[static_cast<size_t>(i)];
      forces[i] = e.fresh ? -r[e.v] : 0;
    }
    out = oscillators.mobility() * forces;
  }

  /// Motions of all coordinates that go with these of the elastic ones: joints hold, no momentum comes of it. Forces on
  /// the elastic coordinates alone that give them, by conjugate gradients in the factor made last.
  /// `lambda`, if any, gains the multipliers that go with it.
  VectorX completed(const VectorX& elastic, VectorX* lambda = nullptr) {
    constexpr int kMostRounds = 12;
    constexpr double kAccuracy = 1e-3, kHeldShare = 1e-3;
    VectorX x = zero_v_, r = elastic, z = inertia_ * r, p = z;
    double rz = r.dot(z);
    for (int round = 0; round < kMostRounds && r.norm() > kAccuracy * elastic.norm(); ++round) {
      VectorX motion = zero_v_, rows = zero_rows_;
      for (Eigen::Index i = 0; i < p.size(); ++i) motion[elastic_[static_cast<size_t>(i)].v] = p[i];
      equations_.solve(motion, rows);
      VectorX Ap(p.size());
      for (Eigen::Index i = 0; i < p.size(); ++i) Ap[i] = motion[elastic_[static_cast<size_t>(i)].v];
      const double pAp = p.dot(Ap);
      if (!(pAp > kHeldShare * rz)) break;  // what is left, joints hold
      const double step = rz / pAp;
      r -= step * Ap;
      x += step * motion;
      if (lambda) *lambda += step * rows;
      z = inertia_ * r;
      const double next = r.dot(z);
      p = z + next / rz * p;
      rz = next;
    }
    joints_hold_ &= r.norm() < kFollows * elastic.norm() || elastic.norm() == 0;
    return x;
  }

  /// A sample with these motions of the elastic coordinates added.
  State moved(Eigen::Index sample, const VectorX& displacement, const VectorX& rate, const VectorX& acceleration) {
    State state = embedded_[static_cast<size_t>(sample)];
    factorize(state);
    const VectorX d = completed(displacement);
    VectorX dv = completed(rate), da = completed(acceleration, &state.lambda);
    for (const Layout::BodySlice& b : system_.layout().bodies()) {
      if (!b.frame) continue;
      const Matrix3 A = rotation_matrix(Vector4(state.q.segment<4>(b.q + 3)));
      const Vector3 w = A * state.v.segment<3>(b.v + 3), w_dot = A * state.v_dot.segment<3>(b.v + 3);
      const Vector3 x = d.segment<3>(b.v), x_dot = dv.segment<3>(b.v);
      dv.segment<3>(b.v) += w.cross(x);
      da.segment<3>(b.v) += w_dot.cross(x) + w.cross(w.cross(x)) + 2 * w.cross(x_dot);
    }
    state.v += dv;
    state.v_dot += da;
    VectorX q(state.q.size());
    system_.layout().retract(state.q, d, q);
    state.q = q;
    return state;
  }
  State moved(Eigen::Index sample, const DrivenOscillators::Response& response) {
    return moved(sample, response.displacement.col(sample), response.rate.col(sample),
                 response.acceleration.col(sample));
  }

  void read(const State& state, std::vector<double>& row) {
    State looked = state;
    looked.lambda.resize(0);
    snapshot_.evaluate(looked);
    std::size_t column = 1;
    for (const Sensor& sensor : sensors_) {
      sensor.evaluate(snapshot_, std::span<double>(row).subspan(column, sensor.columns().size()));
      column += sensor.columns().size();
    }
  }

  /// What the deformation leaves over of the richer equations goes to the motion at large.
  void record_feedback(const State& state, Eigen::Index sample, std::vector<RecordedWrench::Parameters>& feedback) {
    VectorX r(zero_v_.size()), before(zero_v_.size());
    leave_over(embedded_[static_cast<size_t>(sample)], before);
    leave_over(state, r);
    r -= before;
    for (RecordedWrench::Parameters& on : feedback) {
      const int v = system_.layout().slice(*on.marker.body).v;
      const Vector3 force = -r.segment<3>(v), torque = -r.segment<3>(v + 3);  // world, body axes, at the frame's origin
      const MarkerKinematics k = marker_kinematics(equations_, on.marker, Level::position);
      on.force.col(sample / stride_) = force;
      on.torque.col(sample / stride_) = k.R.transpose() * (*k.A * (torque - k.r.cross(k.A->transpose() * force)));
    }
  }
  void leave_over(const State& state, VectorX& r) {
    equations_.recall(state.quarter_turns);
    equations_.evaluate(state.time, state.q, state.v, Level::velocity);
    equations_.residual(state.v_dot, state.lambda, r);
  }

  const System& system_;
  const BodyModels& bodies_;
  const ModelRun& run_;
  const std::vector<Sensor>& sensors_;
  int stride_;
  Detail detail_;
  Embedding embedding_;
  Evaluator equations_;
  Snapshot snapshot_;
  VectorX zero_v_, zero_rows_;
  std::vector<Embedding::Elastic> elastic_;
  std::vector<Marker> loaded_;
  std::vector<State> embedded_;
  MatrixX inertia_;
  bool joints_hold_ = true;  // with the motions completed last
};

}  // namespace

ModelError model_error(SystemGraph& graph, BodyModels& bodies, const ModelRun& run, const std::vector<Fidelity>& richer,
                       const std::vector<Sensor>& sensors, int stride, Detail detail) {
  bodies.set(richer);
  const System system = assemble(graph);
  return Estimate(system, bodies, run, richer, sensors, stride, detail).make();
}

std::vector<double> sample_differences(const std::vector<Sensor>& sensors, const Table& a, const Table& b) {
  std::vector<double> largest(sensors.size(), 0);
  const int rows = a.row_count(), others = b.row_count();
  for (int row = 0, other = 0; row < rows; ++row) {
    const double time = a.at(row, 0), slack = 1e-9 * a.at(rows - 1, 0);
    while (other < others && b.at(other, 0) < time - slack) ++other;
    if (other == others) break;
    if (b.at(other, 0) > time + slack) continue;
    int column = 1;
    for (std::size_t s = 0; s < sensors.size(); ++s) {
      double squares = 0;
      for (std::size_t i = 0; i < sensors[s].columns().size(); ++i, ++column)
        squares += std::pow(a.at(row, column) - b.at(other, column), 2);
      largest[s] = std::max(largest[s], std::sqrt(squares));
    }
  }
  return largest;
}

std::vector<double> sample_changes(const std::vector<Sensor>& sensors, const Table& samples) {
  Table first = samples;
  const std::size_t width = samples.columns.size();
  for (std::size_t i = 0; i < first.values.size(); ++i)
    if (i % width > 0) first.values[i] = samples.values[i % width];
  return sample_differences(sensors, samples, first);
}

}  // namespace lithe
