#pragma once

#include <concepts>
#include <memory>
#include <string>
#include <type_traits>
#include <typeindex>
#include <typeinfo>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

#include "engine/base/error.h"
#include "engine/base/parameters.h"
#include "engine/model/batch_factories.h"
#include "engine/model/constraint.h"
#include "engine/model/contact_element.h"
#include "engine/model/force_element.h"
#include "engine/model/ground.h"
#include "engine/model/input.h"
#include "engine/model/joint_coordinate.h"

namespace lithe {

// Types by name and what is made of them (engine/plugin/registry.h).
struct JointType;
struct ForceType;
struct BodyType;
class JointFromC;
class ForceFromC;
class BodyFromC;

/// What the user draws: bodies tied by constraints, force elements and contacts at markers. Owns every element;
/// addresses last as long as the graph. Calls give name, markers, parameters, in that order.
class SystemGraph {
 public:
  struct Parameters {
    Vector3 gravity{0, 0, -9.81};  // m/s², world axes
  };

  SystemGraph();
  explicit SystemGraph(Parameters parameters);
  SystemGraph(SystemGraph&&) noexcept;
  SystemGraph& operator=(SystemGraph&&) noexcept;
  ~SystemGraph();

  /// The inertial frame; its markers connect elements to the world.
  Ground& ground() { return *ground_; }
  const Vector3& gravity() const { return parameters_.gravity; }

  /// Adds a body; `more` goes to its constructor. Throws SceneError (name in use, bad parameter), naming the line.
  template <class T, class... More>
  requires std::derived_from<T, Body> T& add(Located name, typename T::Parameters parameters = {}, More... more) {
    T& body = keep(name, [&] { return std::make_unique<T>(std::move(parameters), std::move(more)...); });
    enter(BodyEntry{&body, typeid(T), make_body_batch<T>});
    return body;
  }

  /// Adds a constraint or a force element between markers. Throws SceneError likewise, and for markers of another
  /// graph.
  template <class T>
  requires(!std::derived_from<T, Body> && !std::same_as<T, Input>) &&
      std::constructible_from<T, typename T::Parameters> T& add(Located name, std::vector<Marker> markers,
                                                                typename T::Parameters parameters = {}) {
    return connect(keep(name, [&] { return std::make_unique<T>(std::move(parameters)); }), std::move(markers));
  }
  template <class T>
  requires(!std::derived_from<T, Body>) &&
      (!requires { typename T::Parameters; })T& add(Located name, std::vector<Marker> markers) {
    return connect(keep(name, [] { return std::make_unique<T>(); }), std::move(markers));
  }

  /// Adds an input: a quantity given from outside while a run goes on. Throws SceneError likewise.
  template <std::same_as<Input> T>
  T& add(Located name, Input::Parameters parameters = {}) {
    T& input = keep(name, [&] { return std::make_unique<Input>(std::move(parameters)); });
    enter(input);
    return input;
  }

  /// Adds an element of a type known by name, compiled in or loaded: graph.add(registry.joint("massless_rod"),
  /// "string", {A, B}, {{"length", 0.5}}). Throws SceneError likewise, and for parameters that the type does not have.
  JointFromC& add(const JointType& type, Located name, std::vector<Marker> markers,
                  const ParameterList& parameters = {});
  ForceFromC& add(const ForceType& type, Located name, std::vector<Marker> markers,
                  const ParameterList& parameters = {});
  BodyFromC& add(const BodyType& type, Located name, const ParameterList& parameters = {});

  /// Adds an element that acts on joint coordinates: {pin.angle()}, {slide.displacement(), screw.angle()}.
  template <class T>
  requires std::constructible_from<T, CoordinateSet, typename T::Parameters> T& add(
      Located name, std::vector<JointCoordinate> coordinates, typename T::Parameters parameters = {}) {
    std::vector<Marker> markers;
    T& element = keep(name, [&] {
      CoordinateSet set(std::move(coordinates));
      markers = set.markers();
      return std::make_unique<T>(std::move(set), std::move(parameters));
    });
    return connect(element, std::move(markers));
  }

  /// Adds a contact between its colliders (joints/contact/contact.h), each a marker and a shape.
  template <class T>
  requires std::derived_from<T, ContactElement> T& add(Located name, std::vector<typename T::Collider> colliders,
                                                       typename T::Parameters parameters = {}) {
    std::vector<Marker> markers;
    for (const auto& collider : colliders) markers.push_back(collider.marker);
    return connect(keep(name, [&] { return std::make_unique<T>(std::move(colliders), std::move(parameters)); }),
                   std::move(markers));
  }

  struct BodyEntry {
    Body* body;
    std::type_index type;
    std::unique_ptr<BodyBatch> (*make_batch)();
  };
  struct ConstraintEntry {
    Constraint* constraint;
    std::vector<Marker> markers;
    std::type_index type;
    std::unique_ptr<ConstraintBatch> (*make_batch)();
  };
  struct ForceEntry {
    ForceElement* force;
    std::vector<Marker> markers;
    std::type_index type;
    std::unique_ptr<ForceBatch> (*make_batch)();
    int place;  // among force elements and contacts, in the order in which they were added
  };
  struct ContactEntry {
    ContactElement* contact;
    std::vector<Marker> markers;  // one a collider
    std::type_index type;
    int place;  // as of ForceEntry
  };
  const std::vector<BodyEntry>& bodies() const { return bodies_; }  // ground first
  const std::vector<ConstraintEntry>& constraints() const { return constraints_; }
  const std::vector<ForceEntry>& forces() const { return forces_; }
  const std::vector<ContactEntry>& contacts() const { return contacts_; }
  /// In the order in which they were added.
  const std::vector<Input*>& inputs() const { return inputs_; }
  /// The input of that name. Throws SceneError, listing the inputs that there are.
  Input& input(const Located& name) const;
  /// Calls on_force(entry) or on_contact(entry) for each of both, in the order in which they were added: that of sums
  /// of loads and energies, of files and of pages.
  template <class OnForce, class OnContact>
  void for_each_load(OnForce&& on_force, OnContact&& on_contact) const {
    auto force = forces_.begin();
    auto contact = contacts_.begin();
    while (force != forces_.end() || contact != contacts_.end())
      if (contact == contacts_.end() || (force != forces_.end() && force->place < contact->place))
        on_force(*force++);
      else
        on_contact(*contact++);
  }
  int load_count() const { return static_cast<int>(forces_.size() + contacts_.size()); }

  /// A graph of some elements of `whole`, which stays their owner and must outlive it: its ground, and what is shared.
  /// Elements of its own may be added too. For parts of a scene, and scenes simplified
  /// (engine/simplify/simplification.h).
  static std::unique_ptr<SystemGraph> part_of(SystemGraph& whole);
  void share(const BodyEntry& entry);
  /// Attached to other markers than in the graph that owns it: those of substitute bodies. SceneError for markers
  /// of bodies that are not in this graph.
  void share(const ConstraintEntry& entry, std::vector<Marker> markers);
  void share(const ForceEntry& entry, std::vector<Marker> markers);
  void share(const ContactEntry& entry, std::vector<Marker> markers);

  /// Body, constraint, force or contact of that name; null if there is none.
  const Element* find(const std::string& name) const;
  /// The same as its own type or a base of it: graph.find<RevoluteJoint>("pin"), graph.find<Body>("link"). Null if
  /// there is none; SceneError if that name is of something else.
  template <class T>
  const T* find(const std::string& name) const {
    const Element* element = find(name);
    const T* found = dynamic_cast<const T*>(element);
    if (element && !found) refuse_type(*element, typeid(T));
    return found;
  }
  template <class T>
  T* find(const std::string& name) {
    return const_cast<T*>(std::as_const(*this).template find<T>(name));
  }
  /// The graph as Graphviz text: bodies are boxes, connectors ellipses.
  std::string graphviz() const;

 private:
  // Each source that draws a scene compiles these for each type it adds: what does not depend on the type is not here.
  template <class Make>
  auto& keep(const Located& name, Make make) {
    using T = std::remove_reference_t<decltype(*make())>;
    return static_cast<T&>(keep_made(
        name, [](void* by) -> std::unique_ptr<Element> { return (*static_cast<Make*>(by))(); }, &make));
  }
  template <class T>
  T& connect(T& element, std::vector<Marker> markers) {
    if constexpr (std::derived_from<T, Constraint>)
      enter(ConstraintEntry{&element, std::move(markers), typeid(T), make_constraint_batch<T>});
    else if constexpr (std::derived_from<T, ContactElement>)
      enter(ContactEntry{&element, std::move(markers), typeid(T), 0});
    else
      enter(ForceEntry{&element, std::move(markers), typeid(T), make_force_batch<T>, 0});
    return element;
  }
  Element& keep_made(const Located& name, std::unique_ptr<Element> (*make)(void* by), void* by);
  void enter(BodyEntry entry);
  void enter(Input& input);
  void enter(ConstraintEntry entry);
  void enter(ForceEntry entry);
  void enter(ContactEntry entry);
  struct PartOf {
    SystemGraph& whole;
  };
  explicit SystemGraph(PartOf part);
  void check_name(const Located& name) const;
  [[noreturn]] static void refuse_type(const Element& element, const std::type_info& wanted);
  void check_shared(const Element& element, const std::vector<Marker>& markers) const;
  void adopt(std::unique_ptr<Element> element, const Located& name);
  void tie(Connector& element, const std::vector<Marker>& markers);

  Parameters parameters_;
  Ground* ground_;
  std::vector<std::unique_ptr<Element>> elements_;
  std::unordered_map<std::string, const Element*> by_name_;
  std::unordered_set<const Body*> body_set_;
  std::vector<BodyEntry> bodies_;
  std::vector<ConstraintEntry> constraints_;
  std::vector<ForceEntry> forces_;
  std::vector<ContactEntry> contacts_;
  std::vector<Input*> inputs_;
};

extern template std::unique_ptr<BodyBatch> make_body_batch<Ground>();

}  // namespace lithe
