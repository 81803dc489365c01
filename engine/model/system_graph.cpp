#include "engine/model/system_graph.h"

#include <map>

#include "engine/base/checks.h"
#include "engine/base/class_name.h"
#include "engine/factor/graph_topology.h"

namespace lithe {

SystemGraph::SystemGraph() : SystemGraph(Parameters{}) {}

SystemGraph::SystemGraph(Parameters parameters) : parameters_(std::move(parameters)) {
  try {
    require::finite(parameters_.gravity, "gravity");
  } catch (const SceneError& error) {
    throw SceneError(error.problem(), "SystemGraph", error.fix());
  }
  auto ground = std::make_unique<Ground>();
  ground_ = ground.get();
  adopt(std::move(ground), Located("ground"));
  enter(BodyEntry{ground_, typeid(Ground), make_body_batch<Ground>});
}

SystemGraph::SystemGraph(SystemGraph&&) noexcept = default;
SystemGraph& SystemGraph::operator=(SystemGraph&&) noexcept = default;
SystemGraph::~SystemGraph() = default;

SystemGraph::SystemGraph(PartOf part) : parameters_(part.whole.parameters_), ground_(part.whole.ground_) {
  share(part.whole.bodies_.front());
  for (Input* input : part.whole.inputs_) {
    inputs_.push_back(input);
    by_name_[input->name()] = input;
  }
}

std::unique_ptr<SystemGraph> SystemGraph::part_of(SystemGraph& whole) {
  return std::unique_ptr<SystemGraph>(new SystemGraph(PartOf{whole}));
}

void SystemGraph::share(const BodyEntry& entry) {
  bodies_.push_back(entry);
  body_set_.insert(entry.body);
  by_name_[entry.body->name()] = entry.body;
}

void SystemGraph::share(const ConstraintEntry& entry, std::vector<Marker> markers) {
  check_shared(*entry.constraint, markers);
  constraints_.push_back(entry);
  constraints_.back().markers = std::move(markers);
  by_name_[entry.constraint->name()] = entry.constraint;
}

void SystemGraph::share(const ForceEntry& entry, std::vector<Marker> markers) {
  check_shared(*entry.force, markers);
  const int place = load_count();
  forces_.push_back(entry);
  forces_.back().markers = std::move(markers);
  forces_.back().place = place;
  by_name_[entry.force->name()] = entry.force;
}

void SystemGraph::share(const ContactEntry& entry, std::vector<Marker> markers) {
  check_shared(*entry.contact, markers);
  const int place = load_count();
  contacts_.push_back(entry);
  contacts_.back().markers = std::move(markers);
  contacts_.back().place = place;
  by_name_[entry.contact->name()] = entry.contact;
}

void SystemGraph::check_shared(const Element& element, const std::vector<Marker>& markers) const {
  for (const Marker& m : markers)
    if (!m.body || !body_set_.contains(m.body) || m.index < 0 || m.index >= m.body->marker_count())
      throw SceneError("'" + element.name() + "' is tied to a body that this part of the graph does not have",
                       element.where(), "share its bodies first");
}

void SystemGraph::check_name(const Located& name) const {
  if (name.text.empty())
    throw SceneError("an element has no name", to_string(name.where), "give a name: messages and outputs use it");
  const Element* other = find(name.text);
  if (other && other == ground_)
    throw SceneError("the name '" + name.text + "' is that of the fixed body, which every graph has",
                     to_string(name.where), "give another name; the fixed body is graph.ground()");
  if (other)
    throw SceneError("the name '" + name.text + "' is in use since " + other->where(), to_string(name.where),
                     "give every body, joint and force its own name");
}

Element& SystemGraph::keep_made(const Located& name, std::unique_ptr<Element> (*make)(void* by), void* by) {
  check_name(name);
  try {
    std::unique_ptr<Element> element = make(by);
    Element& made = *element;
    adopt(std::move(element), name);
    return made;
  } catch (const SceneError& error) {
    throw SceneError("'" + name.text + "': " + error.problem(), to_string(name.where), error.fix());
  } catch (...) {
    rethrow_as_error("'" + name.text + "'", to_string(name.where), "see what its constructor says");
  }
}

void SystemGraph::enter(BodyEntry entry) {
  body_set_.insert(entry.body);
  bodies_.push_back(std::move(entry));
}

void SystemGraph::enter(Input& input) { inputs_.push_back(&input); }

void SystemGraph::enter(ConstraintEntry entry) {
  tie(*entry.constraint, entry.markers);
  constraints_.push_back(std::move(entry));
}

void SystemGraph::enter(ForceEntry entry) {
  tie(*entry.force, entry.markers);
  entry.place = load_count();
  forces_.push_back(std::move(entry));
}

void SystemGraph::enter(ContactEntry entry) {
  tie(*entry.contact, entry.markers);
  entry.place = load_count();
  contacts_.push_back(std::move(entry));
}

void SystemGraph::adopt(std::unique_ptr<Element> element, const Located& name) {
  element->name_ = name.text;
  element->where_ = to_string(name.where);
  by_name_[name.text] = element.get();
  elements_.push_back(std::move(element));
}

void SystemGraph::tie(Connector& element, const std::vector<Marker>& markers) {
  const auto refuse = [&](const std::string& what, const std::string& fix) {
    const std::string name = element.name(), where = element.where();
    by_name_.erase(name);
    elements_.pop_back();  // the element was never part of the scene
    throw SceneError("'" + name + "': " + what, where, fix);
  };
  if (const int expected = element.marker_count(); static_cast<int>(markers.size()) != expected)
    refuse("needs " + std::to_string(expected) + " markers and got " + std::to_string(markers.size()),
           "list its markers in braces, one on each body it ties");
  for (std::size_t i = 0; i < markers.size(); ++i) {
    const Marker& m = markers[i];
    const std::string which = "marker " + std::to_string(i + 1);
    if (!m.body)
      refuse(which + " belongs to no body (the joint is disconnected)", "make markers with body.marker(...)");
    if (!body_set_.contains(m.body))
      refuse(which + " belongs to a body of another graph", "tie bodies of one graph only");
    if (m.index < 0 || m.index >= m.body->marker_count())
      refuse(which + " does not exist on body '" + m.body->name() + "'", "make markers with body.marker(...)");
  }
  element.markers_ = markers;
}

Input& SystemGraph::input(const Located& name) const {
  std::string known;
  for (Input* input : inputs_) {
    if (input->name() == name.text) return *input;
    known += (known.empty() ? "'" : ", '") + input->name() + "'";
  }
  throw SceneError("the scene has no input '" + name.text + "'", to_string(name.where),
                   known.empty() ? "draw one: graph.add<Input>(\"" + name.text + "\", {.unit = \"N m\"})"
                                 : "its inputs are " + known);
}

const Element* SystemGraph::find(const std::string& name) const {
  const auto at = by_name_.find(name);
  return at == by_name_.end() ? nullptr : at->second;
}

void SystemGraph::refuse_type(const Element& element, const std::type_info& wanted) {
  throw SceneError(
      "'" + element.name() + "' is a " + class_name(typeid(element).name()) + ", not a " + class_name(wanted.name()),
      element.where(), "ask for its own type or a base of it, or look up another name");
}

std::string SystemGraph::graphviz() const {
  GraphDrawing drawing;
  std::map<const Body*, int> number;
  for (const BodyEntry& b : bodies_) {
    number[b.body] = static_cast<int>(drawing.nodes.size());
    drawing.nodes.push_back({b.body->name(), std::to_string(b.body->coordinates().v_count()) + " velocities", true});
  }
  const auto connect = [&](const Element& e, const std::string& type, const std::vector<Marker>& markers) {
    const int node = static_cast<int>(drawing.nodes.size());
    drawing.nodes.push_back({e.name(), type, false});
    for (const Marker& m : markers) drawing.edges.push_back({number[m.body], node});
  };
  for (const auto& c : constraints_)
    connect(*c.constraint, std::to_string(c.constraint->row_count()) + " rows", c.markers);
  for_each_load([&](const ForceEntry& f) { connect(*f.force, "force", f.markers); },
                [&](const ContactEntry& c) { connect(*c.contact, "contact", c.markers); });
  return ::lithe::graphviz(drawing);
}

}  // namespace lithe
