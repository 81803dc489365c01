// A PID controller as an FMU for model exchange, as another tool would export it: FMI 3.0, those functions alone that
// an importer of such a model calls. Knows nothing of Lithe.
//   e = target - angle,  integral' = e,  filtered' = (e - filtered) / filter
//   torque = proportional e + integration · integral + derivation · filtered'
#include <cstddef>
#include <initializer_list>

namespace {

enum Variable { kTime, kAngle, kTarget, kTorque, kIntegral, kFiltered, kOfIntegral, kOfFiltered, kP, kI, kD, kFilter };
constexpr int kOk = 0, kError = 3;

struct Controller {
  double values[12] = {0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0.01};

  void evaluate() {
    double* v = values;
    v[kOfIntegral] = v[kTarget] - v[kAngle];
    v[kOfFiltered] = (v[kOfIntegral] - v[kFiltered]) / v[kFilter];
    v[kTorque] = v[kP] * v[kOfIntegral] + v[kI] * v[kIntegral] + v[kD] * v[kOfFiltered];
  }
};

double* values(void* instance) { return static_cast<Controller*>(instance)->values; }

}  // namespace

#define EXPORT extern "C" __attribute__((visibility("default")))

EXPORT void* fmi3InstantiateModelExchange(const char*, const char*, const char*, bool, bool, void*,
                                          void (*)(void*, int, const char*, const char*)) {
  return new Controller;
}
EXPORT void fmi3FreeInstance(void* instance) { delete static_cast<Controller*>(instance); }
EXPORT int fmi3EnterInitializationMode(void*, bool, double, double, bool, double) { return kOk; }
EXPORT int fmi3ExitInitializationMode(void*) { return kOk; }
EXPORT int fmi3EnterContinuousTimeMode(void*) { return kOk; }
EXPORT int fmi3UpdateDiscreteStates(void*, bool* again, bool* end, bool* nominals, bool* states, bool* next, double*) {
  *again = *end = *nominals = *states = *next = false;
  return kOk;
}
EXPORT int fmi3SetTime(void*, double) { return kOk; }
EXPORT int fmi3SetFloat64(void* instance, const unsigned* which, std::size_t count, const double* from, std::size_t) {
  for (std::size_t i = 0; i < count; ++i) values(instance)[which[i]] = from[i];
  return kOk;
}
EXPORT int fmi3GetFloat64(void* instance, const unsigned* which, std::size_t count, double* to, std::size_t) {
  static_cast<Controller*>(instance)->evaluate();
  for (std::size_t i = 0; i < count; ++i) to[i] = values(instance)[which[i]];
  return kOk;
}
EXPORT int fmi3SetContinuousStates(void* instance, const double* from, std::size_t) {
  values(instance)[kIntegral] = from[0], values(instance)[kFiltered] = from[1];
  return kOk;
}
EXPORT int fmi3GetContinuousStates(void* instance, double* to, std::size_t) {
  to[0] = values(instance)[kIntegral], to[1] = values(instance)[kFiltered];
  return kOk;
}
EXPORT int fmi3GetContinuousStateDerivatives(void* instance, double* to, std::size_t) {
  static_cast<Controller*>(instance)->evaluate();
  to[0] = values(instance)[kOfIntegral], to[1] = values(instance)[kOfFiltered];
  return kOk;
}
/// The model is linear: along a seed its outputs change as they are at values that are the seed.
EXPORT int fmi3GetDirectionalDerivative(void* instance, const unsigned* unknown, std::size_t unknowns,
                                        const unsigned* known, std::size_t knowns, const double* seed,
                                        std::size_t seeds, double* out, std::size_t) {
  if (knowns != seeds) return kError;
  Controller along = *static_cast<Controller*>(instance);
  for (const Variable i : {kAngle, kTarget, kIntegral, kFiltered}) along.values[i] = 0;
  for (std::size_t i = 0; i < knowns; ++i) along.values[known[i]] = seed[i];
  along.evaluate();
  for (std::size_t i = 0; i < unknowns; ++i) out[i] = along.values[unknown[i]];
  return kOk;
}
