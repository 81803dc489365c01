#include <algorithm>
#include <bit>
#include <cmath>

#include "engine/assembly/evaluator.h"
#include "engine/assembly/system.h"
#include "engine/base/error.h"
#include "engine/base/number_text.h"
#include "engine/run/checkpoint.h"
#include "engine/run/followed_inputs.h"

namespace lithe {
namespace {

/// Numbers with no order in them, from -1 to 1, the same ones everywhere.
VectorX mixture(Eigen::Index size, unsigned seed) {
  VectorX out(size);
  for (Eigen::Index i = 0; i < size; ++i) {
    seed = seed * 1664525u + 1013904223u;
    out[i] = static_cast<double>(seed >> 8) / (1 << 23) - 1;
  }
  return out;
}

[[noreturn]] void differ(const Archive& archive, const std::string& what) {
  throw SceneError("the checkpoint is of another scene: " + what, archive.source(),
                   "resume in the scene that wrote it, or start a new run in this one");
}

/// Names, types and markers, an element a text.
std::vector<std::string> elements(const System& system) {
  std::vector<std::string> texts;
  const SystemGraph& graph = system.graph();
  const auto markers = [](const std::vector<Marker>& all) {
    std::string text;
    for (const Marker& m : all) text += " " + m.body->name() + ":" + std::to_string(m.index);
    return text;
  };
  for (const auto& b : graph.bodies()) texts.push_back("body '" + b.body->name() + "' " + b.type.name());
  for (const auto& c : graph.constraints())
    texts.push_back("constraint '" + c.constraint->name() + "' " + c.type.name() + markers(c.markers));
  graph.for_each_load(
      [&](const SystemGraph::ForceEntry& f) {
        texts.push_back("force '" + f.force->name() + "' " + f.type.name() + markers(f.markers));
      },
      [&](const SystemGraph::ContactEntry& c) {
        texts.push_back("contact '" + c.contact->name() + "' " + c.type.name() + markers(c.markers));
      });
  for (const Input* input : graph.inputs()) texts.push_back("input '" + input->name() + "'");
  return texts;
}

std::string name_of(const std::string& element) {
  return element.substr(0, element.find('\'', element.find('\'') + 1) + 1);
}

/// First place where they differ, in bits; -1: nowhere.
Eigen::Index first_difference(const VectorX& a, const VectorX& b) {
  for (Eigen::Index i = 0; i < std::min(a.size(), b.size()); ++i)
    if (std::bit_cast<std::uint64_t>(a[i]) != std::bit_cast<std::uint64_t>(b[i])) return i;
  return a.size() == b.size() ? -1 : std::min(a.size(), b.size());
}

std::string both(const VectorX& then, const VectorX& now, Eigen::Index i) {
  if (i >= then.size() || i >= now.size()) return "";
  std::string text = " (a probe of it gives ";
  append_number(text, now[i]);
  append_number(text += ", then ", then[i]);
  const double scale = std::max(std::abs(then[i]), std::abs(now[i]));
  return text +
         (std::abs(then[i] - now[i]) < 1e-12 * scale ? ": round-off, as of another compiler or processor)" : ")");
}

}  // namespace

SceneFingerprint::SceneFingerprint(const System& system) : system_(system), elements_(elements(system)) {
  initial_.resize(system.initial_state().q.size() + system.initial_state().v.size());
  initial_ << system.initial_state().q, system.initial_state().v;
  // Off the drawn state a little, where springs stretch and dampers move; as drawn where that cannot be.
  if (!sample(1e-2)) sample(0);
}

/// False where the equations give no finite values.
bool SceneFingerprint::sample(double away) {
  const State& drawn = system_.initial_state();
  const Layout& layout = system_.layout();
  const int nv = layout.v_count(), rows = layout.row_count();
  VectorX q = drawn.q;
  const VectorX v = drawn.v + 10 * away * mixture(nv, 1), v_dot = mixture(nv, 3), lambda = mixture(rows, 4);
  layout.retract(drawn.q, away * mixture(nv, 2), q);
  const InputsAsDrawn as_drawn(system_.graph());
  try {
    Evaluator equations(system_);
    equations.recall(drawn.quarter_turns);
    equations.recall(drawn.contacts);
    equations.evaluate(drawn.time + away, q, v, Level::acceleration);
    own_.resize(nv), all_.resize(nv), rows_.resize(3 * rows);
    equations.residual(VectorX::Zero(nv), VectorX::Zero(rows), all_);
    equations.residual(v_dot, VectorX::Zero(rows), own_);
    own_ -= all_;
    equations.residual(v_dot, lambda, all_);
    equations.constraint(Level::position, rows_.head(rows));
    equations.constraint(Level::velocity, rows_.segment(rows, rows));
    equations.constraint(Level::acceleration, rows_.tail(rows));
    const VectorX& of_forces = equations.workspace().force_energy;
    const auto& bodies = system_.graph().bodies();
    energy_.resize(3 * static_cast<Eigen::Index>(bodies.size() - 1) + of_forces.size());
    Eigen::Index at = 0;
    for (std::size_t i = 1; i < bodies.size(); ++i) {
      const BodyEnergy e = bodies[i].body->energy(equations.body_state(i), system_.gravity());
      for (double joules : {e.kinetic, e.elastic, e.gravity}) energy_[at++] = joules;
    }
    energy_.tail(of_forces.size()) = of_forces;
  } catch (const Error&) {
    return false;
  }
  return own_.allFinite() && all_.allFinite() && rows_.allFinite() && energy_.allFinite();
}

void SceneFingerprint::same_elements(Archive& archive) const {
  const std::vector<std::string>& now = elements_;
  std::vector<std::string> then = now;
  archive("elements", then);
  if (then == now) return;
  const auto count = [](const std::vector<std::string>& texts, const std::string& kind) {
    return std::count_if(texts.begin(), texts.end(), [&](const std::string& t) { return t.starts_with(kind); });
  };
  for (const char* kind : {"body", "constraint", "force", "contact", "input"})
    if (const auto had = count(then, kind), has = count(now, kind); had != has)
      differ(archive, "it had " + std::to_string(had) + " elements of the kind '" + kind + "', this one has " +
                          std::to_string(has) + ", ground counted among bodies");
  for (std::size_t i = 0; i < now.size(); ++i) {
    if (then[i] == now[i]) continue;
    if (name_of(then[i]) == name_of(now[i]))
      differ(archive, name_of(now[i]) + " is of another type, or tied elsewhere");
    differ(archive, "where it had " + name_of(then[i]) + ", this one has " + name_of(now[i]));
  }
}

void SceneFingerprint::same(Archive& archive) const {
  archive.group("scene", [&] {
    same_elements(archive);
    const bool loads = archive.loads();
    const auto of_then = [&](const char* name, const VectorX& now) {
      VectorX then = loads ? VectorX() : now;  // of any size
      archive(name, then);
      return then;
    };
    const VectorX own = of_then("own", own_), energy = of_then("energy", energy_), rows = of_then("rows", rows_),
                  all = of_then("all", all_), initial = of_then("initial", initial_);
    if (!loads) return;
    const auto& bodies = system_.layout().bodies();
    const auto owner = [&](Eigen::Index velocity) {
      std::size_t b = 0;
      while (b + 1 < bodies.size() && bodies[b + 1].v <= velocity) ++b;
      return b < bodies.size() ? "'" + bodies[b].name + "'" : std::string("none");
    };
    // What elements are by themselves, then what they do together.
    if (const auto i = first_difference(own, own_); i >= 0)
      differ(archive, "the same elements, but other parameters of body " + owner(i) + both(own, own_, i));
    if (const auto i = first_difference(energy, energy_); i >= 0) {
      const auto& elements = system_.graph().bodies();
      const auto of_bodies = static_cast<Eigen::Index>(3 * (elements.size() - 1));
      std::string name =
          i < of_bodies ? "body '" + elements[static_cast<std::size_t>(i) / 3 + 1].body->name() + "'" : "forces";
      const auto is_it = [&](const Connector& element, int place) {
        if (place == i - of_bodies) name = "'" + element.name() + "'";
      };
      system_.graph().for_each_load([&](const auto& f) { is_it(*f.force, f.place); },
                                    [&](const auto& c) { is_it(*c.contact, c.place); });
      differ(archive, "the same elements, but other parameters or gravity of " + name + both(energy, energy_, i));
    }
    if (const auto i = first_difference(rows, rows_); i >= 0) {
      const int count = std::max(system_.layout().row_count(), 1);
      const std::string name = count > i % count && rows_.size() > 0
                                   ? system_.layout().row_name(static_cast<int>(i % count))
                                   : std::string("none");
      differ(archive,
             "the same elements, but other parameters or places of the joint in " + name + both(rows, rows_, i));
    }
    if (const auto i = first_difference(all, all_); i >= 0)
      differ(archive, "the same elements, but other forces or joints at body " + owner(i) + both(all, all_, i));
    if (const auto i = first_difference(initial, initial_); i >= 0)
      differ(archive, "the same elements, but drawn in another state" + both(initial, initial_, i));
  });
}

}  // namespace lithe
