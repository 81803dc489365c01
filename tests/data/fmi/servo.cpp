// A controller as an FMU, by FMI 2.0 and 3.0 in one library, written from the standards: torque = gain e +
// integral_gain ∫e, e = target - angle; the integral by Euler's method, a step a call. `fault`: 1 is an error, 2 gives
// NaN, 3 discards. `gains` are an array that does nothing.
#include <cmath>
#include <cstdint>
#include <cstring>
#include <new>

namespace {

enum Variable : unsigned {
  kAngle,
  kTarget,
  kGain,
  kIntegralGain,
  kTorque,
  kIntegral,
  kEnabled,
  kFault,
  kGains,
  kVariables = kGains + 3
};

struct Servo {
  double values[kVariables] = {0, 0, 1, 0, 0, 0, 1, 0, 1, 2, 3};
  double time = 0;
  bool stepping = false;
  void (*tell)(void* environment, int status, const char* message) = nullptr;
  void* environment = nullptr;

  void answer() {
    const double error = values[kTarget] - values[kAngle];
    values[kTorque] = values[kEnabled] != 0 ? values[kGain] * error + values[kIntegralGain] * values[kIntegral] : 0;
    if (values[kFault] == 2) values[kTorque] = NAN;
  }
  int step(double from, double size) {
    if (!stepping || from != time) return tell(environment, 3, "a step from another time"), 3;
    if (values[kFault] == 1 && from > 0.0975) return tell(environment, 3, "the amplifier is too hot"), 3;
    if (values[kFault] == 3) return 2;
    values[kIntegral] += size * (values[kTarget] - values[kAngle]);
    time = from + size;
    answer();
    return 0;
  }
};

Servo& of(void* unit) { return *static_cast<Servo*>(unit); }

template <class Number>
int get(void* unit, const unsigned* references, std::size_t count, Number* values) {
  for (std::size_t i = 0; i < count; ++i) {
    if (references[i] >= kVariables) return 3;
    values[i] = static_cast<Number>(of(unit).values[references[i]]);
  }
  return 0;
}
template <class Number>
int set(void* unit, const unsigned* references, std::size_t count, const Number* values) {
  for (std::size_t i = 0; i < count; ++i) {
    if (references[i] >= kVariables) return 3;
    of(unit).values[references[i]] = static_cast<double>(values[i]);
  }
  return 0;
}

// Its state is its numbers, time and mode.
constexpr std::size_t kState = sizeof(double) * (kVariables + 2);
int save(void* unit, void** state) {
  auto* numbers = new double[kVariables + 2];
  std::memcpy(numbers, of(unit).values, sizeof of(unit).values);
  numbers[kVariables] = of(unit).time, numbers[kVariables + 1] = of(unit).stepping;
  *state = numbers;
  return 0;
}
int load(void* unit, void* state) {
  const auto* numbers = static_cast<const double*>(state);
  std::memcpy(of(unit).values, numbers, sizeof of(unit).values);
  of(unit).time = numbers[kVariables], of(unit).stepping = numbers[kVariables + 1] != 0;
  return 0;
}
int forget(void** state) {
  delete[] static_cast<double*>(*state);
  *state = nullptr;
  return 0;
}

}  // namespace

#define EXPORT extern "C" __attribute__((visibility("default")))

// ---- FMI 2.0 ----

namespace {
using Logger2 = void (*)(void*, const char*, int, const char*, const char*, ...);
struct Callbacks2 {
  Logger2 logger;
  void *allocate, *release, *finished, *environment;
};
void tell2(void* callbacks, int status, const char* message) {
  const auto* to = static_cast<const Callbacks2*>(callbacks);
  to->logger(to->environment, "servo", status, "logStatusError", "%s", message);
}
}  // namespace

EXPORT void* fmi2Instantiate(const char*, int type, const char* guid, const char*, Callbacks2* callbacks, int, int) {
  if (type != 1 || std::strcmp(guid, "servo-1") != 0) return nullptr;
  auto* servo = new Servo;
  servo->tell = tell2, servo->environment = callbacks;
  return servo;
}
EXPORT void fmi2FreeInstance(void* unit) { delete static_cast<Servo*>(unit); }
EXPORT int fmi2SetupExperiment(void* unit, int, double, double start, int, double) { return of(unit).time = start, 0; }
EXPORT int fmi2EnterInitializationMode(void*) { return 0; }
EXPORT int fmi2ExitInitializationMode(void* unit) { return of(unit).stepping = true, of(unit).answer(), 0; }
EXPORT int fmi2DoStep(void* unit, double time, double size, int) { return of(unit).step(time, size); }
EXPORT int fmi2GetReal(void* u, const unsigned* r, std::size_t n, double* v) { return get(u, r, n, v); }
EXPORT int fmi2SetReal(void* u, const unsigned* r, std::size_t n, const double* v) { return set(u, r, n, v); }
EXPORT int fmi2GetInteger(void* u, const unsigned* r, std::size_t n, int* v) { return get(u, r, n, v); }
EXPORT int fmi2SetInteger(void* u, const unsigned* r, std::size_t n, const int* v) { return set(u, r, n, v); }
EXPORT int fmi2GetBoolean(void* u, const unsigned* r, std::size_t n, int* v) { return get(u, r, n, v); }
EXPORT int fmi2SetBoolean(void* u, const unsigned* r, std::size_t n, const int* v) { return set(u, r, n, v); }
EXPORT int fmi2GetFMUstate(void* unit, void** state) { return save(unit, state); }
EXPORT int fmi2SetFMUstate(void* unit, void* state) { return load(unit, state); }
EXPORT int fmi2FreeFMUstate(void*, void** state) { return forget(state); }
EXPORT int fmi2SerializedFMUstateSize(void*, void*, std::size_t* size) { return *size = kState, 0; }
EXPORT int fmi2SerializeFMUstate(void*, void* state, char* bytes, std::size_t size) {
  return std::memcpy(bytes, state, size), 0;
}
EXPORT int fmi2DeSerializeFMUstate(void*, const char* bytes, std::size_t size, void** state) {
  *state = new double[kVariables + 2];
  return std::memcpy(*state, bytes, size), 0;
}

// ---- FMI 3.0 ----

namespace {
struct Log3 {
  void* environment;
  void (*message)(void*, int, const char*, const char*);
};
void tell3(void* log, int status, const char* message) {
  const auto* to = static_cast<const Log3*>(log);
  to->message(to->environment, status, "logStatusError", message);
}
}  // namespace

EXPORT void* fmi3InstantiateCoSimulation(const char*, const char* token, const char*, bool, bool, bool, bool,
                                         const unsigned*, std::size_t, void* environment,
                                         void (*message)(void*, int, const char*, const char*), void*) {
  if (std::strcmp(token, "servo-1") != 0) return nullptr;
  auto* servo = new Servo;
  servo->tell = tell3, servo->environment = new Log3{environment, message};
  return servo;
}
EXPORT void fmi3FreeInstance(void* unit) {
  if (!unit) return;
  delete static_cast<Log3*>(of(unit).environment);
  delete static_cast<Servo*>(unit);
}
EXPORT int fmi3EnterInitializationMode(void* unit, bool, double, double start, bool, double) {
  return of(unit).time = start, 0;
}
EXPORT int fmi3ExitInitializationMode(void* unit) { return of(unit).stepping = true, of(unit).answer(), 0; }
EXPORT int fmi3DoStep(void* unit, double time, double size, bool, bool* event, bool* end, bool* early, double* last) {
  *event = *end = *early = false, *last = time + size;
  return of(unit).step(time, size);
}
namespace {
// The numbers of an array lie one after the other: here one variable is asked for at a time.
template <class Number, class Access>
int each(void* unit, const unsigned* first, Number* values, std::size_t size, Access access) {
  for (unsigned k = 0; k < size; ++k)
    if (const unsigned reference = *first + k; access(unit, &reference, 1, values + k) != 0) return 3;
  return 0;
}
}  // namespace
#define GET_AND_SET(TYPE, NUMBER)                                                                        \
  EXPORT int fmi3Get##TYPE(void* u, const unsigned* r, std::size_t, NUMBER* v, std::size_t size) {       \
    return each(u, r, v, size, get<NUMBER>);                                                             \
  }                                                                                                      \
  EXPORT int fmi3Set##TYPE(void* u, const unsigned* r, std::size_t, const NUMBER* v, std::size_t size) { \
    return each(u, r, v, size, set<NUMBER>);                                                             \
  }
GET_AND_SET(Float64, double)
GET_AND_SET(Int32, std::int32_t)
GET_AND_SET(Boolean, bool)
EXPORT int fmi3GetFMUState(void* unit, void** state) { return save(unit, state); }
EXPORT int fmi3SetFMUState(void* unit, void* state) { return load(unit, state); }
EXPORT int fmi3FreeFMUState(void*, void** state) { return forget(state); }
EXPORT int fmi3SerializedFMUStateSize(void*, void*, std::size_t* size) { return *size = kState, 0; }
EXPORT int fmi3SerializeFMUState(void*, void* state, std::uint8_t* bytes, std::size_t size) {
  return std::memcpy(bytes, state, size), 0;
}
EXPORT int fmi3DeserializeFMUState(void*, const std::uint8_t* bytes, std::size_t size, void** state) {
  *state = new double[kVariables + 2];
  return std::memcpy(*state, bytes, size), 0;
}
