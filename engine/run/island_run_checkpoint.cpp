#include <cmath>

#include "engine/base/error.h"
#include "engine/run/island_run.h"

namespace lithe {

void IslandRun::checkpoint(std::string path, Schedule schedule) {
  if (path.empty()) throw SceneError("checkpoints need a path", "Simulation::checkpoint", "give one, as in \"run.h5\"");
  checkpoints_ = {std::move(path), schedule};
}

void IslandRun::save(State& state, Archive& archive) {
  check(state, state.time);
  begin(state);
  history(archive, state);
  started_ = true;
}

State IslandRun::resume(Archive& archive) {
  State state = system_.initial_state();
  started_ = false;  // unless all goes well
  history(archive, state);
  started_ = true;
  return state;
}

/// Within a run.
void IslandRun::write_due_checkpoint(State& state) {
  if (!checkpoints_.pass(state.time)) return;
  Archive archive(checkpoints_.path());
  history(archive, state);
  started_ = true;  // where it cannot be written, the next run goes on
  write_checkpoint(archive, checkpoints_.path());
  started_ = false;
}

/// Saves or loads all that later runs depend on; the state is the one that the integrator has come to.
void IslandRun::history(Archive& archive, State& state) {
  const bool loads = archive.loads();
  if (!scene_) scene_.emplace(system_);
  scene_->same(archive);
  archive.same("integrator", integrator_.name());
  archive.group("inputs", [&] { inputs_.history(archive); });
  // 1. The state, as the integrator is given it.
  if (loads) {
    for (VectorX* x : {&state.v_dot, &state.lambda, &state.quarter_turns}) x->resize(0);
    state.left_out.clear();
  }
  archive("state", state);
  if (loads) check_loaded(archive, state);
  // 2. The integrator's past; where it cannot tell, a new beginning here as there.
  bool tells = false;
  archive.group("method", [&] {
    if (loads) {
      State begun = state;
      integrator_.start(equations_, begun);
    }
    tells = integrator_.history(archive, equations_, state);
    if (!tells && !loads) restart(state);
  });
  steps_ = integrator_.statistics().steps;
  archive("earlier", earlier_);
  if (!(lithe::same(state, last_) && !loads)) last_ = state, evaluated_ = false;
  // 3. Events.
  archive.group("events", [&] {
    archive.same("count", static_cast<double>(watched_events_.size()));
    for (std::size_t i = 0; i < watched_events_.size(); ++i)
      archive.group(std::to_string(i), [&] {
        archive.same("name", watched_events_[i].name);
        archive.same("level", watched_events_[i].level);
        archive.same("direction", static_cast<double>(watched_events_[i].direction));
        archive.same("action", static_cast<double>(watched_events_[i].action));
      });
    if (finder_) finder_->history(archive);
    std::vector<double> times, speeds, impulses;
    std::vector<std::string> names;
    std::vector<int> numbers, contacts;  // contacts: change, colliders
    for (const EventRecord& e : events_) {
      times.push_back(e.time), names.push_back(e.name), numbers.push_back(e.index);
      contacts.insert(contacts.end(), {static_cast<int>(e.contact.change), e.contact.a, e.contact.b});
      speeds.push_back(e.contact.speed), impulses.push_back(e.contact.impulse);
    }
    archive("times", times);
    archive("names", names);
    archive("numbers", numbers);
    archive("contacts", contacts);
    archive("speeds", speeds);
    archive("impulses", impulses);
    const std::size_t count = times.size();
    if (names.size() != count || numbers.size() != count || contacts.size() != 3 * count || speeds.size() != count ||
        impulses.size() != count)
      throw FileError("the checkpoint's events are not whole", archive.source(), "resume from an older one");
    events_.clear();
    for (std::size_t i = 0; i < count; ++i)
      events_.push_back({times[i],
                         names[i],
                         numbers[i],
                         {static_cast<ContactChange>(contacts[3 * i]), contacts[3 * i + 1], contacts[3 * i + 2],
                          speeds[i], impulses[i]}});
    archive("approached", approach_.watched);
    archive("tries", approach_.tries);
    archive("approach_time", approach_.time);
    if (loads && approach_.watched != -1 &&
        !(finder_ && is_switch(approach_.watched) && approach_.watched < finder_->count() && approach_.tries > 0 &&
          approach_.time > state.time))
      throw FileError("the checkpoint approaches a switch that this scene does not have, or that has passed",
                      archive.source(), "resume from an older one");
    archive("restarts", restarts_);
    archive("first_restart", first_restart_);
    archive("stopped_by", stopped_by_);
  });
  // 4. Those who are told.
  archive.group("observers", [&] { watches_.history(archive); });
  if (!tells && loads) {  // only now: what holds may depend on what observers keep
    integrator_.start(equations_, state);
    steps_ = integrator_.statistics().steps;
    last_ = state, evaluated_ = false;
  }
  if (loads && finder_) finder_->resume(integrator_, state);
  archive.group("checkpoints", [&] { checkpoints_.history(archive); });
}

/// Throws FileError for a state that does not fit the scene.
void IslandRun::check_loaded(const Archive& archive, const State& state) const {
  const Layout& layout = system_.layout();
  const auto fits = [](const VectorX& x, Eigen::Index size) { return x.size() == 0 || x.size() == size; };
  bool sound = fits(state.v_dot, layout.v_count()) && fits(state.lambda, layout.row_count()) &&
               fits(state.quarter_turns, system_.initial_state().quarter_turns.size()) && std::isfinite(state.time) &&
               state.q.allFinite() && state.v.allFinite() && system_.may_leave_out(state.left_out);
  for (const ContactTrace& trace : state.contacts)
    sound = sound && trace.element >= 0 && trace.element < static_cast<int>(system_.contacts().size()) &&
            std::holds_alternative<RigidMemory>(trace.memory) ==
                (system_.contacts()[trace.element].element->law() == ContactElement::Law::rigid) &&
            trace.point.position.allFinite() && trace.point.normal.allFinite() && std::isfinite(trace.point.gap) &&
            trace.force.allFinite() && trace.moment.allFinite();
  if (!sound)
    throw FileError("the checkpoint's state does not fit the scene, or is not finite", archive.source(),
                    "resume from an older one, or start a new run");
}

}  // namespace lithe
