#include "engine/study/solve.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <sstream>

#include "engine/base/error.h"
#include "engine/base/log.h"
#include "engine/base/number_text.h"
#include "engine/model/contact_element.h"
#include "engine/model/islands.h"
#include "engine/simplify/simplification.h"
#include "engine/study/solve_internal.h"
#include "engine/study/study_run.h"

namespace lithe {
namespace {

Precision checked(Precision precision, std::source_location where) {
  if (!(precision.value > 0) || !std::isfinite(precision.value))
    throw SceneError("a precision is " + short_number(precision.value), to_string(where),
                     "give a positive number: percent(1), within(1e-3)");
  return precision;
}

}  // namespace

Precision percent(double value, std::source_location where) { return checked({value / 100, true}, where); }
Precision within(double bound, std::source_location where) { return checked({bound, false}, where); }

Solution solve(SystemGraph& graph, double duration, const std::vector<Want>& wants, const SolveMethods& methods,
               const SolveOptions& options) {
  const double begun = thread_seconds();
  BodyModels bodies(graph);
  std::vector<CertificateCost> costs;
  const solving::Asked asked = solving::ask(graph, bodies, duration, wants, methods, options, costs);
  std::optional<log::Quiet> quiet;  // the drawing of each model would repeat what the simplification's has said
  if (options.simplify) quiet.emplace();
  if (asked.impacts) {
    solving::RigidMotion rigid;
    const solving::Answer answer = solving::answer_with_impacts(asked, rigid);
    return solving::certify(asked, rigid, answer, begun);
  }
  const solving::RigidMotion rigid = solving::look_at_rigid(asked);
  const solving::Choice choice = solving::choose(asked, rigid);
  const solving::Answer answer = choice.rigid
                                     ? solving::accept_rigid(asked, rigid, choice)
                                     : solving::refine_meshes(asked, rigid, solving::refine(asked, rigid, choice));
  return solving::certify(asked, rigid, answer, begun);
}

}  // namespace lithe

namespace lithe::solving {
namespace {

/// Which contacts there are, and what is not known of them.
void look_at_contacts(Asked& asked) {
  for (const auto& entry : asked.graph.contacts()) {
    const ContactElement* contact = entry.contact;
    if (contact->law() == ContactElement::Law::sensing) continue;
    asked.contacts = true;
    if (contact->law() == ContactElement::Law::rigid) {
      if (!asked.methods.by_step_with_impacts)
        throw SceneError("'" + contact->name() + "' has rigid surfaces, and no method given to solve() takes impulses",
                         contact->where(), "give SolveMethods::by_step_with_impacts, or the contact a Compliance law");
      asked.impacts = true;
      continue;
    }
    const auto touches = [&](const DeformableBody* body) {
      return std::any_of(entry.markers.begin(), entry.markers.end(), [&](const Marker& m) { return m.body == body; });
    };
    for (const DeformableBody* body : asked.bodies.bodies())
      if (touches(body))
        asked.remarks.push_back(
            "'" + contact->name() + "' touches '" + body->name() +
            "': where an impact is shorter than the time between samples, which modes it drives is not well known");
  }
}

/// Whether the graph can be simplified, and how.
void look_for_simplification(Asked& asked) {
  Simplification simple(asked.graph);
  const std::size_t islands = split(simple.graph()).size();
  asked.simplify = simple.smaller() || islands > 1;
  asked.redundant = !simple.whole().redundant_rows().empty();
  std::istringstream lines(simple.report());
  for (std::string line; std::getline(lines, line);) asked.simplification.push_back(line);
  if (islands > 1) asked.simplification.push_back(std::to_string(islands) + " islands have steps of their own");
}

}  // namespace

Asked ask(SystemGraph& graph, BodyModels& bodies, double duration, const std::vector<Want>& wants,
          const SolveMethods& methods, const SolveOptions& options, std::vector<CertificateCost>& costs) {
  if (wants.empty()) throw SceneError("nothing is wanted", "solve", "say what: want(position(tip), percent(1))");
  if (!(duration > 0) || !std::isfinite(duration))
    throw SceneError("the duration is " + short_number(duration) + " s", "solve", "give a positive time");
  if (options.samples < 4 || options.most_runs < 1)
    throw SceneError("solve needs at least 4 samples and one run", "solve", "give more");
  Asked asked{graph, bodies, duration, wants, methods, options, costs};
  for (const Want& w : wants) asked.sensors.push_back(w.sensor);
  for (DeformableBody* body : bodies.bodies()) body->body_frame();
  look_at_contacts(asked);
  asked.finer = std::max(1, (kFewestSamples + options.samples - 1) / options.samples);
  for (int stride = 2; asked.samples() / stride >= kLooks; ++stride)
    if (asked.samples() % stride == 0) asked.stride = stride;
  if (options.simplify) look_for_simplification(asked);
  return asked;
}

}  // namespace lithe::solving
