#pragma once

#include <nvector/nvector_serial.h>

#include <exception>
#include <string>

#include "engine/base/checks.h"
#include "engine/base/error.h"
#include "engine/base/math.h"
#include "engine/base/sundials_context_internal.h"

namespace lithe {

/// Throws SceneError for steps, tolerances or an order that `method` cannot have.
template <class Parameters>
void check_sundials(const char* method, const Parameters& parameters, int highest_order) {
  require::at(method, [&] {
    require::not_negative(parameters.first_step, "first_step");
    require::not_negative(parameters.max_step, "max_step");
    require::not_negative(parameters.tolerance.relative, "relative tolerance");
    require::positive(parameters.tolerance.absolute, "absolute tolerance");
  });
  if (parameters.max_order < 1 || parameters.max_order > highest_order)
    throw SceneError("max_order is " + std::to_string(parameters.max_order), method,
                     "give 1 to " + std::to_string(highest_order));
}

/// What the solvers of SUNDIALS have in common here: their context, and callbacks that let no exception into C. To be
/// derived from, as struct Memory : SundialsMemory<Memory>, which owns all else.
template <class Memory>
struct SundialsMemory {
  SUNContext context = make_sundials_context();
  std::string thrown, said;  // by the engine within a callback; by SUNDIALS

  // 6 gives each solver what hears its messages, 7 the context.
#if SUNDIALS_VERSION_MAJOR < 7
  SundialsMemory() = default;
  static void message(int, const char*, const char*, char* text, void* user) { hear(text, user); }
#else
  SundialsMemory() {
    if (!context) return;
    SUNContext_ClearErrHandlers(context);
    SUNContext_PushErrHandler(context, message, static_cast<Memory*>(this));
  }
  static void message(int, const char*, const char*, const char* text, SUNErrCode, void* user, SUNContext) {
    hear(text, user);
  }
#endif
  ~SundialsMemory() {
    if (context) SUNContext_Free(&context);
  }
  SundialsMemory(const SundialsMemory&) = delete;
  SundialsMemory& operator=(const SundialsMemory&) = delete;

  static Eigen::Map<VectorX> map(N_Vector x) { return {N_VGetArrayPointer(x), N_VGetLength(x)}; }

  /// Runs a callback; an exception becomes text and "cannot continue", values that are not finite become "try a smaller
  /// step".
  template <class Body>
  static int guarded(void* user, Body&& body) noexcept {
    auto& memory = *static_cast<Memory*>(user);
    try {
      return body(memory) ? 0 : 1;
    } catch (const std::exception& error) {
      try {
        memory.thrown = error.what();
      } catch (...) {
      }
    } catch (...) {
    }
    return -1;
  }

  static void hear(const char* text, void* user) {
    guarded(user, [&](Memory& m) {
      m.said = text;
      return true;
    });
  }

  /// Throws SimulationError.
  void require(bool done, const char* what, const char* where) const {
    if (!done)
      throw SimulationError(std::string("SUNDIALS cannot be set up: ") + what + (said.empty() ? "" : ", " + said),
                            where, "is the state finite and the memory enough?");
  }
};

}  // namespace lithe
