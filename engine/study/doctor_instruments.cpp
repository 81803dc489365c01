#include <algorithm>
#include <ctime>
#include <numbers>
#include <set>

#include "engine/base/number_text.h"
#include "engine/model/marker_motions.h"
#include "engine/observe/stop_run.h"
#include "engine/run/simulation.h"
#include "engine/study/doctor_internal.h"

namespace lithe::doctor {
namespace {

/// Told of every step.
class Probe : public Observer {
 public:
  Probe(Watched& run, const System& system, const Integrator& integrator, const DiagnoseOptions& options)
      : run_(run), integrator_(integrator), options_(options), begun_(std::clock()) {
    const auto add = [&](const Connector& connector) {
      for (const MeasuredAngle& a : connector.angles()) {
        const auto kind = a.to_point ? JointCoordinate::Kind::bearing : JointCoordinate::Kind::angle;
        const JointCoordinate x{kind, connector.markers()[a.A], connector.markers()[a.B], a.axis};
        if (const int place = system.find_angle(x); place >= 0 && places_.insert(place).second)
          turning_.push_back({x, connector.name(), place});
      }
    };
    for (const auto& c : system.graph().constraints()) add(*c.constraint);
    for (const auto& f : system.graph().forces()) add(*f.force);
  }

  void observe(Snapshot& now) override {
    const BodyEnergy energy = now.energy();
    if (run_.times.empty()) run_.first_energy = run_.largest_energy = energy.total();
    run_.largest_energy = std::max(run_.largest_energy, energy.total());
    run_.largest_kinetic = std::max(run_.largest_kinetic, energy.kinetic);
    rows_.resize(now.system().layout().row_count());
    if (rows_.size() > 0) {
      now.evaluator().constraint(Level::position, rows_);
      int row = 0;
      if (const double largest = rows_.cwiseAbs().maxCoeff(&row); largest > run_.residual)
        run_.residual = largest, run_.residual_row = row, run_.residual_time = now.time();
    }
    if (const int i = integrator_.statistics().limiting; i >= 0) ++run_.limiting[i];
    follow_multipliers(now.found_multipliers());
    for (Turning& angle : turning_) follow(angle, now);
    run_.before = run_.times.empty() ? now.state() : run_.last;
    run_.last = now.state();
    run_.times.push_back(now.time());
    if (static_cast<long>(run_.times.size()) % stride_ == 1 || stride_ == 1) keep(now);
    note_dip(now.state());
    const double seconds = static_cast<double>(std::clock() - begun_) / CLOCKS_PER_SEC;
    const bool over = static_cast<long>(run_.times.size()) > options_.max_steps || seconds > options_.time_limit;
    if (over) throw StopRun{"the doctor"};
  }

 private:
  /// An angle whose turns are counted, at the last step.
  struct Turning {
    JointCoordinate x;
    std::string name;
    int place;
    double quarter_turns = 0, rate = 0;
    bool known = false;
  };
  /// Turns are counted by continuity: right as long as the angle moves by less than half a turn a step. How far it
  /// moved its rates tell, to more than half a turn.
  void follow(Turning& angle, Snapshot& now) {
    const double counted = now.state().quarter_turns[angle.place];
    const MarkerKinematics A = now.marker(angle.x.A), B = now.marker(angle.x.B);
    const double rate = measure(angle.x.kind, angle.x.axis, {A, 0}, {B, 1}).rate;
    if (angle.known) {
      const double step = now.time() - run_.times.back(), moved = 0.5 * step * (rate + angle.rate);
      const double lost = std::round(moved / (2 * std::numbers::pi) - (counted - angle.quarter_turns) / 4);
      if (lost != 0 && std::isfinite(lost)) {
        Watched::LostTurns& entry =
            run_.lost_turns.try_emplace(angle.place, Watched::LostTurns{angle.x, angle.name, 0, now.time(), step, rate})
                .first->second;
        entry.turns += static_cast<long>(std::clamp(lost, -1e9, 1e9));
      }
    }
    angle.quarter_turns = counted, angle.rate = rate, angle.known = true;
  }
  void keep(Snapshot& now) {
    constexpr std::size_t kMany = 64;
    run_.samples.push_back(now.state());
    if (run_.samples.size() < kMany) return;
    for (std::size_t i = 0; 2 * i < kMany; ++i) run_.samples[i] = run_.samples[2 * i];
    run_.samples.resize(kMany / 2);
    stride_ *= 2;
  }
  /// Of what alternates, each change undoes the one before: the mean of their product is minus four amplitudes squared.
  void follow_multipliers(const VectorX& lambda) {
    constexpr double kMemory = 0.9;
    if (lambda.size() == 0) return;
    lambda_size_ = std::max(kMemory * lambda_size_, lambda.norm());
    if (change_.size() > 0 && lambda_size_ > 0) {
      const VectorX change = (lambda - lambda_last_) / lambda_size_;
      undone_ = kMemory * undone_ - (1 - kMemory) * change.dot(change_);
      run_.zigzag = std::sqrt(std::max(0.0, undone_)) / 2;
      change_ = change;
    } else if (lambda_last_.size() > 0 && lambda_size_ > 0) {
      change_ = (lambda - lambda_last_) / lambda_size_;
    }
    lambda_last_ = lambda;
  }
  /// The states at the ends of the shortest steps.
  void note_dip(const State& state) {
    constexpr std::size_t kDips = 6;
    if (run_.times.size() < 3) return;
    const double h = state.time - run_.before.time;
    if (dips_.size() < kDips || h < dips_.back()) {
      const auto at = std::upper_bound(dips_.begin(), dips_.end(), h) - dips_.begin();
      dips_.insert(dips_.begin() + at, h);
      run_.dips.insert(run_.dips.begin() + at, state);
      if (dips_.size() > kDips) dips_.pop_back(), run_.dips.pop_back();
    }
  }

  Watched& run_;
  const Integrator& integrator_;
  const DiagnoseOptions& options_;
  std::clock_t begun_;
  std::set<int> places_;
  std::vector<Turning> turning_;
  VectorX rows_, lambda_last_, change_;  // of the multipliers, in their size
  double lambda_size_ = 0, undone_ = 0;
  long stride_ = 1;
  std::vector<double> dips_;
};

}  // namespace

void add_wrench(const Layout& layout, const Marker& marker, const MarkerKinematics& k, const Wrench& w,
                VectorX& force) {
  if (marker.body->coordinates().v_count() == 0) return;  // ground
  const Layout::BodySlice& first = layout.slice(*marker.body);
  if (k.between) {
    Vector6 wrench;
    wrench << w.force, w.torque;
    for (const MarkerBetween::Share& share : k.between->shares)
      force.segment<6>((&first)[share.frame].v) += share.J.transpose() * wrench;
    return;
  }
  const Layout::BodySlice& b = (&first)[k.frame];
  const Vector3 F = k.A->transpose() * w.force, T = k.A->transpose() * w.torque;
  if (b.frame) {
    force.segment<3>(b.v) += w.force;
    force.segment<3>(b.v + 3) += k.r.cross(F) + T;
  }
  if (!k.elastic) return;
  Vector6 local;
  local << F, T;
  const Layout::LinearSlice eta = layout.linear_slice(b);
  force.segment(eta.v, eta.size) += Eigen::Map<const Matrix6X>(k.elastic, 6, eta.size).transpose() * local;
}

std::unique_ptr<Evaluator> factorized(const System& system, const State& state) {
  auto equations = std::make_unique<Evaluator>(system);
  equations->recall(state.quarter_turns);
  equations->evaluate(state.time, state.q, state.v, Level::velocity);
  equations->factorize({0, 0, 1}, VectorX::Zero(system.layout().v_count()), VectorX::Zero(system.layout().row_count()),
                       nullptr);
  return equations;
}

std::string bodies_of(const Connector& connector) {
  std::string text;
  std::vector<const Body*> told;
  for (const Marker& m : connector.markers()) {
    if (std::find(told.begin(), told.end(), m.body) != told.end()) continue;
    if (!told.empty()) text += " and ";
    text += m.body->coordinates().v_count() == 0 ? std::string("ground") : "'" + m.body->name() + "'";
    told.push_back(m.body);
  }
  return text;
}

std::vector<Rate> fastest_rates(const System& system, const State& state) {
  std::vector<Rate> rates;
  Snapshot now(system, state);
  const Layout& layout = system.layout();
  const int n = layout.v_count();
  const VectorX still = VectorX::Zero(n);
  VectorX no_load = VectorX::Zero(layout.row_count()), force(n), motion(n);
  // 1. Elastic coordinates by themselves: ω² = K_ii / M_ii.
  Evaluator equations(system);
  equations.recall(state.quarter_turns);
  equations.evaluate(state.time, state.q, state.v, Level::velocity);
  VectorX mass = still, both = still;
  const auto read_diagonal = [&](VectorX& into) {
    equations.visit_blocks([&](int row, int column, ConstMatrixRef block) {
      if (row < n && row == column) into.segment(row, block.rows()) += block.diagonal();
    });
  };
  equations.factorize({1, 0, 1}, still, no_load, nullptr);
  read_diagonal(both);
  equations.factorize({0, 0, 1}, still, no_load, nullptr);
  read_diagonal(mass);
  for (const Layout::BodySlice& b : layout.bodies())
    for (int i = 0, v = b.v + (b.frame ? 6 : 0); i < b.linear; ++i, ++v)
      if (mass[v] > 0 && both[v] > mass[v])
        rates.push_back(
            {"the elastic coordinate " + layout.velocity_name(v), nullptr, std::sqrt(both[v] / mass[v] - 1)});
  // 2. Force elements: k w·M⁻¹w with the joints in place, w the row's force on the velocities.
  for (const auto& entry : system.graph().forces()) {
    if (entry.force->row_count() == 0) continue;
    const MarkerMotions views(entry.markers, [&](const Marker& m) { return now.marker(m); });
    ForceRows rows(entry.force->marker_count());
    rows.recall(now.quarter_turns_of(*entry.force));
    rows.set_reaction({Vector3::Zero(), Vector3::Zero()});
    entry.force->evaluate(state.time, views, rows);
    Rate rate{"'" + entry.force->name() + "' between " + bodies_of(*entry.force), entry.force};
    if (rows.count() == 1 && views.size() == 2) {
      const Vector3 line = views[1].p - views[0].p;
      const Wrench& w = rows.wrench(0, 1);
      rate.pulls = w.torque.isZero(0) && line.norm() > 0 && w.force.cross(line).norm() < 1e-9 * line.norm();
    }
    for (int r = 0; r < rows.count(); ++r) {
      force.setZero();
      for (std::size_t m = 0; m < views.size(); ++m)
        add_wrench(layout, entry.markers[m], views[m], rows.wrench(r, static_cast<int>(m)), force);
      motion = force;
      no_load.setZero();
      equations.solve(motion, no_load);
      const double mobility = std::max(0.0, force.dot(motion));
      rate.frequency = std::max(rate.frequency, std::sqrt(std::abs(rows.stiffness(r)) * mobility));
      rate.damping = std::max(rate.damping, std::abs(rows.damping(r)) * mobility);
      rate.stiffness = std::max(rate.stiffness, std::abs(rows.stiffness(r)));
    }
    rates.push_back(rate);
  }
  std::stable_sort(rates.begin(), rates.end(), [](const Rate& a, const Rate& b) { return a.largest() > b.largest(); });
  return rates;
}

VectorX force_values(Snapshot& now, const ForceElement& force) {
  VectorX values(6 * force.marker_count());
  for (int m = 0; m < force.marker_count(); ++m) applied_force(force, m).evaluate(now, {values.data() + 6 * m, 6});
  return values;
}

double Watched::median_step() const {
  if (times.size() < 2) return 0;
  std::vector<double> steps;
  for (std::size_t i = 1; i < times.size(); ++i) steps.push_back(times[i] - times[i - 1]);
  std::nth_element(steps.begin(), steps.begin() + static_cast<long>(steps.size() / 2), steps.end());
  return steps[steps.size() / 2];
}

namespace {

/// What the sensors read, one after the other.
std::vector<double> watched(const System& system, const std::vector<Sensor>& sensors, const State& state) {
  Snapshot now(system, state);
  std::vector<double> all;
  for (const Sensor& sensor : sensors) {
    std::vector<double> values(sensor.columns().size());
    sensor.evaluate(now, values);
    all.insert(all.end(), values.begin(), values.end());
  }
  return all;
}

}  // namespace

Watched run_watched(const System& system, const std::vector<Sensor>& sensors, const State& start, double duration,
                    Integrator& integrator, const DiagnoseOptions& options) {
  Watched run;
  run.integrator = integrator.name();
  run.last = run.before = start;
  Simulation simulation{system, integrator};
  Probe probe(run, system, integrator, options);
  simulation.observe(probe, every_step());
  State state = start;
  try {
    simulation.run(state, start.time + duration);
    run.too_slow = !simulation.stopped_by().empty();
    run.reached = !run.too_slow;
    if (run.too_slow)
      run.why = "it had taken " + std::to_string(run.times.size() - 1) + " steps to " + time_text(run.last.time);
    if (run.reached) run.watch_at_end = watched(system, sensors, state);
  } catch (const Error& error) {
    run.reached = false;
    run.why = error.problem();
  } catch (const std::exception& error) {
    run.reached = false;
    run.why = error.what();
  }
  run.statistics = simulation.statistics();
  return run;
}

}  // namespace lithe::doctor
