#pragma once

#include <memory>
#include <string>

#include "engine/base/parameters.h"
#include "engine/model/element.h"
#include "engine/plugin/plugin_loader.h"
#include "engine/plugin_abi.h"

/// The host's side of plug-ins: types known by name, and the objects that they make.
namespace lithe {

/// A type by name: its table, and the library it came from (null: compiled in). Libraries are shared, unlike all else
/// in Lithe: a registry, and graphs that may outlive it, need them loaded, in no order of their own.
template <class Table>
struct PluginType {
  std::string name;
  Table table;
  std::shared_ptr<const PluginLibrary> library;
};
struct JointType : PluginType<lithe_joint_type> {
  static constexpr const char* kKind = "joint";
};
struct ForceType : PluginType<lithe_force_type> {
  static constexpr const char* kKind = "force";
};
struct BodyType : PluginType<lithe_body_type> {
  static constexpr const char* kKind = "body";
};
struct IntegratorType : PluginType<lithe_integrator_type> {
  static constexpr const char* kKind = "integrator";
};

/// Room for the text of an error, handed to C functions.
struct ErrorText {
  char text[1024];
  ErrorText() { text[0] = 0; }
  std::string problem() const;
  std::string fix() const;  // "" if none was given

 private:
  std::string all() const;
};

/// An object made by a type of a plug-in, and by it destroyed. Keeps the library loaded.
class PluginObject {
 public:
  /// Throws SceneError: a parameter's name, kind or size is wrong, or the type refuses its value.
  template <class Type>
  PluginObject(const Type& type, const ParameterList& parameters)
      : description_(describe(Type::kKind, type.name, type.library.get())),
        library_(type.library),
        object_(make(type.table.fields, type.table.field_count, type.table.create, parameters), type.table.destroy) {}

  void* get() const { return object_.get(); }
  /// "joint type 'massless_rod' of massless_rod.so"
  const std::string& description() const { return description_; }
  /// Throws SimulationError: the type failed within an evaluation.
  [[noreturn]] void fail(const Element& element, const ErrorText& why) const;

 private:
  static std::string describe(const char* kind, const std::string& name, const PluginLibrary* library);
  void* make(const lithe_field* fields, size_t field_count,
             void* (*create)(const lithe_parameter*, size_t, char*, size_t), const ParameterList& parameters) const;

  std::string description_;
  std::shared_ptr<const PluginLibrary> library_;  // before the object, so that it is unloaded after
  std::unique_ptr<void, void (*)(void*)> object_;
};

/// "did you mean 'length'? known are a, b, length." Names nearest to a misspelt one first.
std::string name_hint(const std::string& wrong, const std::vector<std::string>& known);

}  // namespace lithe
