#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "engine/base/error.h"
#include "engine/plugin.h"
#include "engine/plugin/body_from_c.h"
#include "engine/plugin/connectors_from_c.h"
#include "engine/plugin/integrator_from_c.h"
#include "engine/plugin/plugin_type.h"

namespace lithe {

/// Types by name, compiled in or loaded:
///   Registry registry;
///   registry.load_plugin("plugins/massless_rod.so");
///   graph.add(registry.joint("massless_rod"), "string", {A, B}, {{"length", 0.5}});
/// Graphs may outlive it: their elements keep the libraries they need.
class Registry {
 public:
  Registry() = default;
  Registry(const Registry&) = delete;
  Registry& operator=(const Registry&) = delete;

  /// Loads a library and registers its types: all of them, or none if it throws. Throws FileError: no such file, no
  /// plug-in, one of another interface, a table that is too small or not whole, a name in use.
  void load_plugin(const std::filesystem::path& library);
  /// The same of a plug-in that is linked into the program, by its entry; `name` is for messages.
  void add_plugin(const std::string& name, int32_t (*entry)(const lithe_host*));
  /// Registers a class that is compiled in: registry.add<MasslessRod>("massless_rod"). Throws SceneError: name in use.
  template <class T>
  void add(Located name);

  /// The type of that name. Throws SceneError that lists the known ones.
  const JointType& joint(Located name) const;
  const ForceType& force(Located name) const;
  const BodyType& body(Located name) const;
  /// A new integrator of that type. Throws SceneError likewise, and for wrong parameters.
  std::unique_ptr<Integrator> integrator(Located name, const ParameterList& parameters = {}) const;

 private:
  template <class Type>
  using Named = std::map<std::string, Type>;
  struct Types {
    Named<JointType> joints;
    Named<ForceType> forces;
    Named<BodyType> bodies;
    Named<IntegratorType> integrators;
  };
  struct Loading;
  void take(const std::shared_ptr<const PluginLibrary>& library, const std::string& source,
            const std::function<void(const lithe_host&)>& hand_over);
  template <class Type>
  void add_compiled(Named<Type>& types, const Located& name, Type type);

  Types types_;
};

template <class T>
void Registry::add(Located name) {
  const char* text = name.text.c_str();
  if constexpr (std::derived_from<T, Constraint>)
    add_compiled(types_.joints, name, {{name.text, plugin::joint_type<T>(text), nullptr}});
  else if constexpr (std::derived_from<T, ForceElement>)
    add_compiled(types_.forces, name, {{name.text, plugin::force_type<T>(text), nullptr}});
  else if constexpr (std::derived_from<T, Body>)
    add_compiled(types_.bodies, name, {{name.text, plugin::body_type<T>(text), nullptr}});
  else
    add_compiled(types_.integrators, name, {{name.text, plugin::integrator_type<T>(text), nullptr}});
}

template <class Type>
void Registry::add_compiled(Named<Type>& types, const Located& name, Type type) {
  if (!types.try_emplace(name.text, std::move(type)).second)
    throw SceneError(std::string("a ") + Type::kKind + " type '" + name.text + "' is registered already",
                     to_string(name.where), "register it once, or under another name");
}

}  // namespace lithe
