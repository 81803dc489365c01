#pragma once

#include "engine/model/appearance.h"
#include "engine/model/body_by_energy.h"
#include "engine/model/joint_by_residual.h"
#include "engine/model/joint_coordinate.h"
#include "engine/plugin/body_to_c.h"
#include "engine/plugin/integrator_to_c.h"
#include "engine/plugin/plugin_tables.h"
#include "engine/plugin_abi.h"

/// All that a plug-in includes: the interfaces, the rows joints are composed of, what measures angles and
/// displacements, parameters by name, what bodies are drawn by, and
///   LITHE_EXPORT_JOINT(Class, "name")   LITHE_EXPORT_FORCE   LITHE_EXPORT_BODY   LITHE_EXPORT_INTEGRATOR
/// which hand a class to whoever loads the library. They are empty unless built by lithe_add_plugin() (CMake), so that
/// the same file can be compiled in. plugins/README.md shows it in one page.
#ifdef LITHE_PLUGIN

namespace lithe::plugin {

/// The types of this library, gathered before its entry is called.
class Export {
 public:
  using HandOver = void (*)(const lithe_host&, const char* name);
  Export(HandOver hand_over, const char* name) : hand_over_(hand_over), name_(name), next_(first()) { first() = this; }

  static int32_t all(const lithe_host* host) noexcept {
    if (!host || host->struct_size < sizeof(lithe_host)) return kFatal;
    for (const Export* e = first(); e; e = e->next_) e->hand_over_(*host, e->name_);
    return kFine;
  }

 private:
  static const Export*& first() {
    static const Export* first = nullptr;
    return first;
  }
  HandOver hand_over_;
  const char* name_;
  const Export* next_;
};

template <class T>
void export_joint(const lithe_host& host, const char* name) {
  static const lithe_joint_type table = joint_type<T>(name);
  host.add_joint(host.context, &table);
}
template <class T>
void export_force(const lithe_host& host, const char* name) {
  static const lithe_force_type table = force_type<T>(name);
  host.add_force(host.context, &table);
}
template <class T>
void export_body(const lithe_host& host, const char* name) {
  static const lithe_body_type table = body_type<T>(name);
  host.add_body(host.context, &table);
}
template <class T>
void export_integrator(const lithe_host& host, const char* name) {
  static const lithe_integrator_type table = integrator_type<T>(name);
  host.add_integrator(host.context, &table);
}

}  // namespace lithe::plugin

// Inline, so that a library of several files has it once; used, so that it is there though nobody calls it.
extern "C" __attribute__((used, visibility("default"))) inline int32_t lithe_plugin_v1(const lithe_host* host) {
  return ::lithe::plugin::Export::all(host);
}

#define LITHE_EXPORT_JOIN_(a, b) a##b
#define LITHE_EXPORT_AT_(line, kind, Class, name) \
  static const ::lithe::plugin::Export LITHE_EXPORT_JOIN_(lithe_export_, line)(::lithe::plugin::kind<Class>, name);
#define LITHE_EXPORT_JOINT(Class, name) LITHE_EXPORT_AT_(__LINE__, export_joint, Class, name)
#define LITHE_EXPORT_FORCE(Class, name) LITHE_EXPORT_AT_(__LINE__, export_force, Class, name)
#define LITHE_EXPORT_BODY(Class, name) LITHE_EXPORT_AT_(__LINE__, export_body, Class, name)
#define LITHE_EXPORT_INTEGRATOR(Class, name) LITHE_EXPORT_AT_(__LINE__, export_integrator, Class, name)

#else

#define LITHE_EXPORT_JOINT(Class, name)
#define LITHE_EXPORT_FORCE(Class, name)
#define LITHE_EXPORT_BODY(Class, name)
#define LITHE_EXPORT_INTEGRATOR(Class, name)

#endif
