#include <algorithm>
#include <cmath>

#include "engine/analysis/linearization.h"
#include "engine/assembly/evaluator.h"
#include "engine/base/number_text.h"
#include "engine/motion/projection.h"
#include "engine/study/doctor_internal.h"

namespace lithe::doctor {
namespace {

/// A state moved along its own motion by `dt`, forwards or backwards.
State moved(const System& system, const State& state, double dt) {
  State out = state;
  out.time += dt;
  const VectorX d = dt * state.v + 0.5 * dt * dt * state.v_dot;
  system.layout().retract(state.q, d, out.q);
  out.v += dt * state.v_dot;
  if (out.quarter_turns.size() == 0) return out;
  // Turns are counted by continuity: on the way, a radian at a time.
  double turned = 0;
  for (const Layout::BodySlice& b : system.layout().bodies())
    if (b.frame) turned = std::max(turned, d.segment<3>(b.v + 3).norm());
  const int parts = static_cast<int>(std::min(1000.0, std::ceil(turned)));
  if (parts <= 1) return out;
  Evaluator equations(system);
  VectorX q = out.q;
  for (int k = 1; k <= parts; ++k) {
    system.layout().retract(state.q, (static_cast<double>(k) / parts) * d, q);
    equations.recall(out.quarter_turns);
    equations.evaluate(out.time, q, out.v, Level::position);
    equations.track(out.quarter_turns);
  }
  return out;
}

/// A step long enough to leave the place where a run failed, s.
double stride(const Case& c) { return std::max(c.run.median_step(), 1e-5 * c.scene.duration); }

/// What a run that blew up shows of forces is its own doing.
bool exploded(const Case& c) { return !(c.growth(c.run) < 1e3); }

std::string named(const ForceElement& force) { return "the force '" + force.name() + "' on " + bodies_of(force); }

}  // namespace

std::vector<Finding> find_no_number(const Case& c) {
  if (exploded(c)) return {};
  const System& system = *c.drawn.system;
  Snapshot now(system);
  for (double ahead : {0.0, 1e-3, 0.03, 1.0, 3.0, 10.0, 30.0}) {
    const State state = moved(system, c.run.last, ahead * stride(c));
    now.evaluate(state);
    for (const auto& entry : system.graph().forces())
      if (!force_values(now, *entry.force).allFinite())
        return {{Cause::no_number, true, 0.99, named(*entry.force) + " is not finite at " + time_text(state.time),
                 "look for a division by a zero distance or speed, a root or a logarithm of what is negative"}};
  }
  if (c.run.why.find("no finite") == std::string::npos && c.run.why.find("not finite") == std::string::npos) return {};
  return {{Cause::no_number, true, 0.5, c.run.why, "look for a law that divides by zero or overflows near there"}};
}

std::vector<Finding> find_jumps(const Case& c) {
  if (exploded(c)) return {};
  const System& system = *c.drawn.system;
  Snapshot now(system);
  std::vector<State> places{c.run.last};
  places.insert(places.end(), c.run.dips.begin(), c.run.dips.end());
  for (const auto& entry : system.graph().forces()) {
    const auto value = [&](const State& place, double dt) {
      now.evaluate(moved(system, place, dt));
      return force_values(now, *entry.force);
    };
    for (const State& place : places) {
      // Bisection towards the larger half of the change: a continuous law has none left in the end.
      double low = -3 * stride(c), high = 3 * stride(c);
      VectorX at_low = value(place, low), at_high = value(place, high);
      const double size = std::max(at_low.norm(), at_high.norm()), change = (at_high - at_low).norm();
      if (!(change > 0.02 * size)) continue;
      for (int k = 0; k < 30; ++k) {
        const double middle = 0.5 * (low + high);
        const VectorX at_middle = value(place, middle);
        if ((at_middle - at_low).norm() > (at_high - at_middle).norm())
          high = middle, at_high = at_middle;
        else
          low = middle, at_low = at_middle;
      }
      const double jump = (at_high - at_low).norm();
      if (!(jump > 0.02 * size) || !std::isfinite(jump)) continue;
      int most = 0;
      (at_high - at_low).cwiseAbs().maxCoeff(&most);
      return {
          {Cause::discontinuity, true, 0.92,
           named(*entry.force) + " jumps from " + number(at_low[most]) + " to " + number(at_high[most]) +
               (most % 6 < 3 ? " N" : " N m") + " at " + time_text(place.time + high) +
               (c.run.rejected_often() ? "; steps were repeated " + std::to_string(c.run.statistics.rejected) + " times"
                                       : ""),
           "let it change over a small but finite speed, distance or time (tanh, smooth_step), end the step there "
           "with Simulation::on(), or give its element switches()"}};
    }
  }
  return {};
}

std::vector<Finding> find_rank_loss(const Case& c) {
  const System& system = *c.drawn.system;
  if (system.layout().row_count() == 0) return {};
  // Ranks over the run, and at its end.
  std::vector<double> ratios;
  const std::size_t every = std::max<std::size_t>(1, c.run.samples.size() / 16);
  RowRanks weakest;
  double least = 2, when = 0;
  const auto look = [&](const State& state) {
    RowRanks rows = row_ranks(system, state);
    const double conditioning = rows.conditioning();
    if (rows.weakest_row >= 0 && conditioning < least)
      least = conditioning, weakest = std::move(rows), when = state.time;
    return conditioning;
  };
  for (std::size_t i = 0; i < c.run.samples.size(); i += every) ratios.push_back(look(c.run.samples[i]));
  look(c.run.last);
  for (const State& dip : c.run.dips) look(dip);
  if (ratios.empty() || weakest.weakest_row < 0) return {};
  // Not the median: a run that creeps up to such a position has most of its steps there.
  const double usual = *std::ranges::max_element(ratios);
  const bool failed_there =
      !c.run.reached && !c.run.too_slow && std::abs(when - c.run.last.time) < 0.02 * c.scene.duration;
  if (!(least < (failed_there ? 0.1 : 1e-3) * usual)) return {};
  // A drive that has a part in it asks for what cannot be reached.
  const VectorX drives = drive_rates(system);
  std::string driven;
  for (std::size_t i = 0; i < weakest.kept.size(); ++i)
    if (drives[weakest.kept[i]] > 0 && weakest.weakest[static_cast<int>(i)] > 0.05)
      driven = system.layout().row_name(weakest.kept[i]);
  const std::string ranks = "the smallest singular value of the rows falls to " + number(least) +
                            " of the largest at " + time_text(when) + " (else " + number(usual) + "), most in " +
                            system.layout().row_name(weakest.weakest_row);
  if (!driven.empty() && !c.run.reached)
    return {{Cause::incompatible_drive, true, 0.94,
             "the drive " + driven + " asks for what the mechanism cannot reach: " + ranks,
             "drive within the reach of the mechanism, or drive another freedom (the crank, not the slider)"}};
  return {{Cause::singular_position, true, failed_there ? 0.87 : 0.8,
           "joints lose rank on the way, in a dead centre or a change point: " + ranks,
           "give a finer tolerance or step so that it is passed on the branch it came by; change lengths a little, or "
           "start off that position"}};
}

std::vector<Finding> find_stiffness(const Case& c) {
  if (!c.is_explicit() || !(c.step() > 0) || c.run.samples.empty()) return {};
  const System& system = *c.drawn.system;
  // 1. Elements by themselves.
  Rate fastest;
  for (const State* state : {&c.run.samples.front(), &c.run.samples[c.run.samples.size() / 2]})
    for (const Rate& rate : fastest_rates(system, *state))
      if (rate.largest() > fastest.largest()) fastest = rate;
  std::string name = fastest.name;
  double rate = fastest.largest();
  bool rings = fastest.frequency >= fastest.damping;
  // 2. Forces that are loads show in the motion of the whole alone.
  if (c.step() * rate < 0.3 && system.layout().v_count() <= 120) {
    try {
      for (const Mode& mode : linearize(system, c.run.samples.front()).modes) {
        if (std::abs(mode.eigenvalue) <= rate) continue;
        int largest = 0;
        mode.shape.cwiseAbs().maxCoeff(&largest);
        name = "the motion of " + system.layout().velocity_name(largest) + " under its forces";
        rate = std::abs(mode.eigenvalue);
        rings = std::abs(mode.eigenvalue.imag()) > std::abs(mode.eigenvalue.real());
      }
    } catch (const Error&) {  // NOLINT: no linearization there, no finding
    }
  }
  const double product = c.step() * rate;
  if (!(product > 0.3) || !(rate * c.scene.duration > 100)) return {};
  std::string limiting;
  if (!c.run.limiting.empty()) {
    const auto most = std::max_element(c.run.limiting.begin(), c.run.limiting.end(),
                                       [](const auto& a, const auto& b) { return a.second < b.second; });
    limiting = "; " + system.layout().velocity_name(most->first) + " limits most steps";
  }
  return {
      {Cause::stiff, true, 0.86,
       name + (rings ? " rings at " : " decays at ") + number(rate) + (rings ? " rad/s" : " 1/s") +
           ", which limits an explicit method to steps of some " + number(3 / rate) + " s: here " + number(c.step()) +
           " s" + limiting,
       "take an implicit method (generalized-alpha, IDA), or a softer element; what need not be seen ringing can be "
       "a joint"}};
}

std::vector<Finding> find_instability(const Case& c) {
  if (c.zigzags())
    return {{Cause::unstable_method, true, 0.89,
             "the multipliers alternate from step to step, by " + number(c.run.zigzag) + " of their size " +
                 setting_words(c.method, c.options.setting) + ", by " + number(c.finer.zigzag) + " " +
                 setting_words(c.method, finer_setting(c.method, c.options.setting)) +
                 ": the method does not damp them",
             "take spectral_radius 0.8 to 0.9 or the form of stabilized index 2; smaller steps do not fix it"}};
  const double coarse = c.growth(c.run), fine = c.growth(c.finer);
  if (!c.conservative || !(coarse > 0.05)) return {};
  const std::string grows = "energy grows by " + number(coarse) + " times the largest kinetic energy " +
                            setting_words(c.method, c.options.setting) + ", by " + number(fine) + " " +
                            setting_words(c.method, finer_setting(c.method, c.options.setting));
  if (fine > 0.03 * coarse)
    return {{Cause::unstable_method, true, 0.9, "the method is not stable here: " + grows + ", though nothing feeds it",
             "take a method with damping at high frequencies (generalized-alpha with spectral_radius 0.8 or less), or "
             "one with error control; smaller steps do not fix it"}};
  return {{Cause::step_too_large, true, 0.75, "the step is too large: " + grows,
           "give a smaller step or a finer tolerance"}};
}

std::vector<Finding> find_inaccuracy(const Case& c) {
  const double finer = finer_setting(c.method, c.options.setting);
  const std::string smaller = c.method.setting == StudyMethod::Setting::step ? "step" : "tolerance";
  if (!c.run.reached) {
    if (!c.finer.reached) return {};
    return {{Cause::step_too_large, true, 0.7,
             "the " + smaller + " is too large: " + c.run.why + "; " + setting_words(c.method, finer) +
                 " the run reaches its end",
             "give a smaller " + smaller}};
  }
  const double off = c.difference(c.run, c.finer);
  if (!(off > 1e-2)) return {};
  // Does a small change grow by itself?
  constexpr double kChange = 1e-8, kChaotic = 1e5;
  const System& system = *c.drawn.system;
  State near = system.initial_state();
  Evaluator equations(system);
  equations.recall(near.quarter_turns);
  for (int i = 0; i < near.v.size(); ++i) near.v[i] += kChange * std::sin(1 + 2.4 * i);
  Projector(equations).velocity(near.time, near.q, near.v);
  const Watched changed =
      run_watched(system, c.drawn.sensors, near, c.scene.duration, *c.method.make(finer), c.options);
  const double growth = c.difference(changed, c.finer) / kChange;
  const std::string differs = "the end " + setting_words(c.method, c.options.setting) + " and " +
                              setting_words(c.method, finer) + " differs by " + number(off) + " characteristic lengths";
  if (growth > kChaotic)
    return {
        {Cause::chaos, true, 0.9,
         differs + ": the motion is chaotic, a change of 1e-8 in the start has grown " + number(growth) + " times",
         "no method can do better for long: ask for statistics or for a shorter time, not for the state at the end"}};
  return {
      {Cause::step_too_large, true, 0.6, "the " + smaller + " is too large: " + differs, "give a smaller " + smaller}};
}

std::vector<Finding> of_run(const Case& c) {
  std::vector<Finding> all;
  for (const auto& find :
       {find_no_number, find_jumps, find_rank_loss, find_stiffness, find_instability, find_inaccuracy})
    for (Finding& finding : find(c)) all.push_back(std::move(finding));
  return all;
}

}  // namespace lithe::doctor
