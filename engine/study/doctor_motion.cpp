#include <numbers>
#include <set>

#include "engine/analysis/left_out.h"
#include "engine/base/number_text.h"
#include "engine/study/doctor_internal.h"

/// What the motion of a run tells of its scene, whether the run went well or not.
namespace lithe::doctor {
namespace {

/// A sensor of the scene that throws, or gives a value that is not finite.
std::vector<Finding> find_bad_sensors(const Case& c) {
  Snapshot now(*c.drawn.system);
  for (const State& state : c.run.samples) {
    now.evaluate(state);
    for (const Sensor& sensor : c.drawn.sensors) {
      const auto bad = [&](const std::string& column, const std::string& what) {
        return std::vector{Finding{
            Cause::no_number, true, 0.97,
            "the sensor " + quoted(column) + " (" + sensor.where() + ") " + what + " at " + time_text(state.time),
            "look for a division by a zero distance or speed, a root or a logarithm of what is negative"}};
      };
      std::vector<double> values(sensor.columns().size());
      try {
        sensor.evaluate(now, values);
      } catch (const std::exception& error) {
        return bad(sensor.columns().front(), std::string("throws '") + error.what() + "'");
      }
      for (std::size_t i = 0; i < values.size(); ++i)
        if (!std::isfinite(values[i])) return bad(sensor.columns()[i], "is not finite");
    }
  }
  return {};
}

/// Rows that repeat others are left out: where they want another motion than these, they come open.
std::vector<Finding> find_opened_rows(const Case& c) {
  if (!c.run.reached && c.run.why.find(kContradict) != std::string::npos) {
    const bool driven = drive_rates(*c.drawn.system).maxCoeff() > 0;
    return {{driven ? Cause::incompatible_drive : Cause::open_joint, true, 0.95, c.run.why,
             driven ? "drive every freedom once; let two drives of one freedom give the same motion"
                    : "see whether the joints that close this loop agree in their lengths and axes"}};
  }
  const double open = 1e-3 * std::min(c.scene.characteristic_length, 1.0);
  if (!c.run.reached || !c.finer.reached || c.run.residual_row < 0) return {};
  if (!(c.run.residual > open) || !(c.finer.residual > 0.3 * c.run.residual)) return {};
  const System& system = *c.drawn.system;
  const VectorX drives = drive_rates(system);
  std::string driven;
  int count = 0;
  for (const Layout::RowSlice& joint : system.layout().rows())
    if (drives.segment(joint.first, joint.count).maxCoeff() > 0 && ++count <= 3)
      driven += (driven.empty() ? "" : ", ") + quoted(joint.name);
  const std::string what = "joint " + system.layout().row_name(c.run.residual_row) + " comes open by " +
                           number(c.run.residual) + " until " + time_text(c.run.residual_time);
  if (count > 0)
    return {{Cause::incompatible_drive, true, 0.95,
             "drives ask for motions that joints or other drives do not allow (" + driven + "): " + what,
             "drive every freedom once; let two drives of one freedom give the same motion"}};
  return {{Cause::open_joint, true, 0.95, what + ", though it repeats others as drawn",
           "see whether the joints that close this loop agree in their lengths and axes"}};
}

/// A stop that a drive pushes into: its coordinate cannot yield.
std::vector<Finding> find_driven_stops(const Case& c) {
  const System& system = *c.drawn.system;
  const Layout& layout = system.layout();
  if (std::ranges::all_of(system.graph().forces(), [](const auto& f) { return f.force->switches().empty(); }))
    return {};
  const VectorX drives = drive_rates(system);
  if (drives.size() == 0 || !(drives.maxCoeff() > 0)) return {};
  Snapshot now(system);
  for (const State& state : c.run.samples) {
    now.evaluate(state);
    for (const auto& entry : system.graph().forces()) {
      const auto switches = entry.force->switches();
      if (switches.empty() || !(force_values(now, *entry.force).norm() > 0)) continue;
      const JointCoordinate& x = switches.front().coordinate;
      double depth = 1e300;
      for (const CoordinateSwitch& limit : switches)
        depth = std::min(depth, std::abs(coordinate(x, "x").value(now) - limit.value));
      if (!(depth > 1e-3 * (x.is_angle() ? 1 : c.scene.characteristic_length))) continue;
      // How it moves under a unit force, beside how its bodies would by themselves.
      const MarkerKinematics A = now.marker(x.A), B = now.marker(x.B);
      const MeasuredCoordinate measured = measure(x.kind, x.axis, {A, 0}, {B, 1});
      VectorX force = VectorX::Zero(layout.v_count()), mass = force, load = VectorX::Zero(layout.row_count());
      add_wrench(layout, x.A, A, measured.on_A, force);
      add_wrench(layout, x.B, B, measured.on_B, force);
      const auto equations = factorized(system, state);
      equations->visit_blocks([&](int row, int column, ConstMatrixRef block) {
        if (row == column && row < mass.size()) mass.segment(row, block.rows()) += block.diagonal();
      });
      VectorX motion = force;
      equations->solve(motion, load);
      const double alone = (force.array().square() / mass.array().max(1e-300)).sum();
      if (!(force.dot(motion) < 1e-8 * alone)) continue;
      // The drives that bear it.
      std::string by;
      for (const Layout::RowSlice& joint : layout.rows())
        if (drives.segment(joint.first, joint.count).maxCoeff() > 0 &&
            load.segment(joint.first, joint.count).cwiseAbs().maxCoeff() > 1e-3 * load.cwiseAbs().maxCoeff())
          by += (by.empty() ? "" : ", ") + quoted(joint.name);
      return {{Cause::incompatible_drive, true, 0.9,
               "the drive " + by + " pushes " + number(depth) + (x.is_angle() ? " rad" : " m") + " into the stop " +
                   quoted(entry.force->name()) + " of " + bodies_of(*entry.force) + " by " + time_text(state.time),
               "keep the drive's motion within the stop, move the stop, or push by a force (CoordinateMotor)"}};
    }
  }
  return {};
}

/// Loads that bend a body in modes that are not in use.
std::vector<Finding> find_missing_modes(const Case& c) {
  std::map<std::string, DeflectionLeftOut> largest;
  const std::size_t every = std::max<std::size_t>(1, c.run.samples.size() / 8);
  for (std::size_t i = 0; i < c.run.samples.size(); i += every)
    for (const DeflectionLeftOut& body : deflection_left_out(*c.drawn.system, c.run.samples[i])) {
      DeflectionLeftOut& most = largest.try_emplace(body.name, body).first->second;
      most.deflection = std::max(most.deflection, body.deflection);
      most.missing = std::max(most.missing, body.missing);
    }
  for (const auto& [name, body] : largest)
    if (body.share() > 0.5 && body.missing > 1e-3 * c.scene.characteristic_length)
      return {{Cause::too_few_modes, true, 0.85,
               "the body " + quoted(name) + " uses " + std::to_string(body.used) + " of its " +
                   std::to_string(body.candidates) + " modes, and its loads bend the others: " + number(body.missing) +
                   " m of " + number(body.deflection) + " m of deflection are left out",
               "use more modes, or static modes of the loaded interfaces (Reduction::loaded)"}};
  return {};
}

/// A force whose power grows faster than the speed, in a motion that it makes grow without end.
std::vector<Finding> find_negative_damping(const Case& c) {
  if (c.run.samples.size() < 8) return {};
  const System& system = *c.drawn.system;
  const std::vector<State>& samples = c.run.samples;
  Snapshot now(system);
  const auto middle = std::ranges::find_if(samples, [&](const State& s) { return 2 * s.time >= samples.back().time; });
  const auto kinetic = [&](const State& state) {
    now.evaluate(state);
    return now.energy().kinetic;
  };
  const double grown = kinetic(samples.back()) / kinetic(*middle);
  if (!(grown > 100)) return {};
  for (const auto& entry : system.graph().forces()) {
    // Power at the speeds of the run and at twice these: of a damper four times as much.
    int feeding = 0, seen = 0;
    for (auto at = middle; at != samples.end(); ++at, ++seen) {
      State faster = *at;
      faster.v *= 2;
      now.evaluate(*at);
      const double once = power(*entry.force).value(now);
      now.evaluate(faster);
      feeding += power(*entry.force).value(now) - 2 * once > 0.1 * std::abs(once);
    }
    if (feeding < seen || seen == 0) continue;
    return {{Cause::negative_damping, true, 0.93,
             "the force " + quoted(entry.force->name()) + " on " + bodies_of(*entry.force) +
                 " feeds the motion, the more the faster it is: the kinetic energy grows " + number(grown) +
                 " times in the second half of the run",
             "give its damping the other sign: a brake's effort is -c times the rate"}};
  }
  return {};
}

/// A spring that cannot carry the weight on it at any length near that as drawn.
std::vector<Finding> find_soft_springs(const Case& c) {
  const System& system = *c.drawn.system;
  if (c.run.samples.empty() || !(system.gravity().norm() > 0)) return {};
  Snapshot start(system, c.run.samples.front()), now(system);
  for (const Rate& rate : fastest_rates(system, c.run.samples.front())) {
    if (!rate.pulls || !(rate.frequency > 0)) continue;
    const std::vector<Marker>& markers = rate.force->markers();
    const double length = (start.marker(markers[1]).p - start.marker(markers[0]).p).norm();
    const double sag = system.gravity().norm() / (rate.frequency * rate.frequency);
    if (!(sag > 3 * length)) continue;
    double longest = 0;
    for (const State& state : c.run.samples) {
      now.evaluate(state);
      longest = std::max(longest, (now.marker(markers[1]).p - now.marker(markers[0]).p).norm());
    }
    if (!(longest > 4 * length)) continue;  // something else carries
    return {{Cause::bad_unit, true, 0.9,
             "the spring " + rate.name + " of " + number(rate.stiffness) + " N/m, drawn " + number(length) +
                 " m long, would sag by " + number(sag) + " m under what it carries, and gets " + number(longest) +
                 " m long",
             "give its stiffness in N/m (1 N/mm is 1000 N/m)"}};
  }
  return {};
}

/// Turns that got lost in steps of more than half a turn, where something reads them. Rates of a run that blew up tell
/// nothing.
std::vector<Finding> find_lost_turns(const Case& c) {
  if (!c.run.reached || !(c.growth(c.run) < 2)) return {};
  const System& system = *c.drawn.system;
  for (const auto& [place, lost] : c.run.lost_turns) {
    if (lost.turns == 0) continue;
    State turned = c.run.last;
    turned.quarter_turns[place] += 4;
    Snapshot now(system, c.run.last), other(system, turned);
    const auto differ = [](const VectorX& a, const VectorX& b) { return !((a - b).norm() <= 1e-9 * (1 + a.norm())); };
    std::string reader;
    for (const auto& entry : system.graph().forces())
      if (reader.empty() && differ(force_values(now, *entry.force), force_values(other, *entry.force)))
        reader = quoted(entry.force->name());
    VectorX g(system.layout().row_count()), g_turned = g;
    now.evaluator().constraint(Level::position, g);
    other.evaluator().constraint(Level::position, g_turned);
    for (int row = 0; row < g.size() && reader.empty(); ++row)
      if (std::abs(g[row] - g_turned[row]) > 1e-6) reader = system.layout().row_name(row);
    for (const Sensor& sensor : c.drawn.sensors) {
      VectorX values(static_cast<Eigen::Index>(sensor.columns().size())), values_turned = values;
      sensor.evaluate(now, {values.data(), sensor.columns().size()});
      sensor.evaluate(other, {values_turned.data(), sensor.columns().size()});
      if (reader.empty() && differ(values, values_turned)) reader = "the sensor " + quoted(sensor.columns().front());
    }
    if (reader.empty()) continue;
    return {{Cause::lost_turns, true, 0.95,
             "the angle of " + quoted(lost.name) + " turned by " + number(lost.step * lost.rate) +
                 " rad in a step of " + number(lost.step) + " s to " + time_text(lost.time) +
                 ": turns are counted up to half a turn a step; " + std::to_string(std::abs(lost.turns)) +
                 (std::abs(lost.turns) == 1 ? " turn is" : " turns are") + " lost over the run, and " + reader +
                 " reads them",
             "hold the steps below " + number(std::numbers::pi / std::abs(lost.rate)) +
                 " s, half a turn (max_step, or the fixed step)"}};
  }
  return {};
}

}  // namespace

std::vector<Finding> of_motion(const Case& c) {
  std::vector<Finding> all;
  for (const auto& find : {find_bad_sensors, find_opened_rows, find_driven_stops, find_missing_modes,
                           find_negative_damping, find_soft_springs, find_lost_turns})
    for (Finding& finding : find(c)) all.push_back(std::move(finding));
  return all;
}

}  // namespace lithe::doctor
