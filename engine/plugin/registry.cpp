#include "engine/plugin/registry.h"

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <set>

#include "engine/model/system_graph.h"

namespace lithe {
namespace {

/// What every table needs, whatever its kind: the functions that may not be null.
bool is_whole(const lithe_joint_type& t) { return t.evaluate && t.marker_count >= 1 && t.row_count >= 1; }
bool is_whole(const lithe_force_type& t) { return t.evaluate && t.marker_count >= 1 && t.row_count >= 0; }
bool is_whole(const lithe_body_type& t) {
  return t.coordinates && t.linear_pattern && t.marker_count && t.initial_state && t.create_cache && t.destroy_cache &&
         t.evaluate && t.add_residual && t.add_tangent && t.marker_kinematics && t.energy;
}
bool is_whole(const lithe_integrator_type& t) { return t.start && t.step && t.statistics; }

/// Joints and forces have room for so many.
template <class Table>
bool is_too_large(const Table& t) {
  if constexpr (requires { t.row_count; }) return t.marker_count > kMaxMarkers || t.row_count > kMaxRows;
  return false;
}

/// What is wrong with the list of parameters; empty: nothing.
std::string fields_problem(const lithe_field* fields, size_t count) {
  constexpr size_t kMost = 1000;
  if (count > kMost) return std::to_string(count) + " parameters";
  if (count > 0 && !fields) return "parameters and no list of them";
  std::set<std::string> names;
  for (size_t i = 0; i < count; ++i) {
    const lithe_field& f = fields[i];
    if (!f.name || !*f.name || !names.insert(f.name).second) return "a parameter without a name of its own";
    if (f.kind < LITHE_NUMBER || f.kind > LITHE_VECTOR || f.size < 0)
      return "a parameter '" + std::string(f.name) + "' of an unknown kind or size";
  }
  return "";
}

/// Bytes of the table as of the first v1: what a plug-in must have; stays when the table grows.
template <class Table>
constexpr size_t kFirstSize = sizeof(Table);
template <>
constexpr size_t kFirstSize<lithe_body_type> = offsetof(lithe_body_type, frame_pairs);
template <>
constexpr size_t kFirstSize<lithe_integrator_type> = offsetof(lithe_integrator_type, save);

template <class Type>
const Type& find(const std::map<std::string, Type>& types, const Located& name) {
  const auto at = types.find(name.text);
  if (at != types.end()) return at->second;
  std::vector<std::string> known;
  for (const auto& [known_name, type] : types) known.push_back(known_name);
  throw SceneError(std::string("no ") + Type::kKind + " type '" + name.text + "' is registered", to_string(name.where),
                   known.empty() ? "load its plug-in first: registry.load_plugin(path)" : name_hint(name.text, known));
}

}  // namespace

/// What a library hands over while it is being loaded; it becomes part of the registry only if all is well.
struct Registry::Loading {
  const Types& known;
  std::shared_ptr<const PluginLibrary> library;
  Types fresh{};
  std::string problem{}, fix{};  // the first
  std::exception_ptr thrown{};

  int32_t refuse(const std::string& what, const std::string& how) {
    if (problem.empty()) problem = what, fix = how;
    return -1;
  }

  /// Nothing that is thrown may cross the border.
  template <class Type, class Table>
  int32_t add(Named<Type> Types::*kind, const Table* table) noexcept {
    try {
      return look_at(kind, table);
    } catch (...) {
      if (!thrown) thrown = std::current_exception();
      return -1;
    }
  }

  template <class Type, class Table>
  int32_t look_at(Named<Type> Types::*kind, const Table* table) {
    const std::string its = std::string("its ") + Type::kKind + " type";
    if (!table || table->struct_size < kFirstSize<Table>)
      return refuse(its + " has a table of " + std::to_string(table ? table->struct_size : 0) + " bytes; version " +
                        std::to_string(LITHE_PLUGIN_VERSION) + " of the interface has " +
                        std::to_string(kFirstSize<Table>),
                    "build the plug-in anew against this Lithe, and set struct_size");
    if (table->struct_size % sizeof(void*) != 0)
      return refuse(
          its + " has a table of " + std::to_string(table->struct_size) + " bytes, which ends within a member",
          "set struct_size to the sizeof of the table's type");
    Type type;
    std::memset(&type.table, 0, sizeof(Table));  // what the plug-in does not know stays null
    std::memcpy(&type.table, table, std::min(table->struct_size, sizeof(Table)));
    type.library = library;
    if (!table->name || !*table->name) return refuse(its + " has no name", "give it one");
    type.name = table->name;
    if (!table->create || !table->destroy || !is_whole(type.table))
      return refuse(its + " '" + type.name + "' lacks a function that it needs, or markers and rows",
                    "fill its table as engine/plugin_abi.h says");
    if (const std::string wrong = fields_problem(type.table.fields, type.table.field_count); !wrong.empty())
      return refuse(its + " '" + type.name + "' has " + wrong, "fill its table as engine/plugin_abi.h says");
    if (is_too_large(type.table))
      return refuse(its + " '" + type.name + "' has more than " + std::to_string(kMaxMarkers) + " markers or " +
                        std::to_string(kMaxRows) + " rows",
                    "make two of it");
    if (const auto at = (known.*kind).find(type.name); at != (known.*kind).end())
      return refuse(std::string("a ") + Type::kKind + " type '" + type.name + "' is registered already, " +
                        (at->second.library ? "from " + at->second.library->path().string() : "compiled in"),
                    "load it once, or give one of the two another name");
    const std::string name = type.name;
    if (!(fresh.*kind).try_emplace(name, std::move(type)).second)
      return refuse(its + " '" + name + "' is exported twice", "export it once");
    return 0;
  }
};

void Registry::load_plugin(const std::filesystem::path& path) {
  const auto library = std::make_shared<const PluginLibrary>(path);
  take(library, path.string(), [&](const lithe_host& host) { library->hand_over_types(host); });
}

void Registry::add_plugin(const std::string& name, int32_t (*entry)(const lithe_host*)) {
  take(nullptr, name, [&](const lithe_host& host) {
    if (const int32_t code = entry(&host); code != 0)
      throw FileError("the plug-in will not serve this Lithe: its entry returned " + std::to_string(code), name,
                      "build the plug-in anew against this Lithe");
  });
}

void Registry::take(const std::shared_ptr<const PluginLibrary>& library, const std::string& source,
                    const std::function<void(const lithe_host&)>& hand_over) {
  Loading loading{types_, library};
  lithe_host host{};
  host.struct_size = sizeof host;
  host.context = &loading;
  host.add_joint = [](void* to, const lithe_joint_type* t) {
    return static_cast<Loading*>(to)->add(&Types::joints, t);
  };
  host.add_force = [](void* to, const lithe_force_type* t) {
    return static_cast<Loading*>(to)->add(&Types::forces, t);
  };
  host.add_body = [](void* to, const lithe_body_type* t) { return static_cast<Loading*>(to)->add(&Types::bodies, t); };
  host.add_integrator = [](void* to, const lithe_integrator_type* t) {
    return static_cast<Loading*>(to)->add(&Types::integrators, t);
  };
  hand_over(host);
  if (loading.thrown) std::rethrow_exception(loading.thrown);
  Types& fresh = loading.fresh;
  if (loading.problem.empty() &&
      fresh.joints.size() + fresh.forces.size() + fresh.bodies.size() + fresh.integrators.size() == 0)
    loading.refuse("the plug-in exports no type", "export one with LITHE_EXPORT_JOINT or its like");
  if (!loading.problem.empty()) throw FileError("the plug-in is refused: " + loading.problem, source, loading.fix);
  types_.joints.merge(fresh.joints);
  types_.forces.merge(fresh.forces);
  types_.bodies.merge(fresh.bodies);
  types_.integrators.merge(fresh.integrators);
}

const JointType& Registry::joint(Located name) const { return find(types_.joints, name); }
const ForceType& Registry::force(Located name) const { return find(types_.forces, name); }
const BodyType& Registry::body(Located name) const { return find(types_.bodies, name); }

std::unique_ptr<Integrator> Registry::integrator(Located name, const ParameterList& parameters) const {
  const IntegratorType& type = find(types_.integrators, name);
  try {
    return std::make_unique<IntegratorFromC>(type, parameters);
  } catch (const SceneError& error) {
    throw SceneError(error.problem(), to_string(name.where), error.fix());
  }
}

// ---- what a graph knows of types by name ----

JointFromC& SystemGraph::add(const JointType& type, Located name, std::vector<Marker> markers,
                             const ParameterList& parameters) {
  return add<JointFromC>(std::move(name), std::move(markers), {&type, parameters});
}
ForceFromC& SystemGraph::add(const ForceType& type, Located name, std::vector<Marker> markers,
                             const ParameterList& parameters) {
  return add<ForceFromC>(std::move(name), std::move(markers), {&type, parameters});
}
BodyFromC& SystemGraph::add(const BodyType& type, Located name, const ParameterList& parameters) {
  return add<BodyFromC>(std::move(name), {&type, parameters});
}

}  // namespace lithe
