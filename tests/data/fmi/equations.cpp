// FMUs for model exchange, by FMI 2.0 and 3.0 in one library, written from the standards. LITHE_TEST_MODEL is one of:
// the models of the Reference FMUs, from their published equations and descriptions, Drive, a controller with a
// slow amplifier, and Robot, six of them in one. Calls that their mode does not allow are errors.
#include <cmath>
#include <cstdint>
#include <cstring>

namespace models {

enum class Mode { instantiated, initialization, event, continuous };

struct Event {
  bool again = false, terminate = false, states_changed = false, has_next = false;
  double next = 0;
};

// Of all models: values by value reference, time and what they remember.
struct Numbers {
  double v[72] = {};
  double time = 0;
  double memory[2] = {};
  Mode mode = Mode::instantiated;
};

// x' = -k x. A kick of one at the end of the first step at or after a time (value 4), if it is not zero.
struct Dahlquist {
  static constexpr unsigned kStates[] = {1}, kDerivatives[] = {2}, kCount = 5;
  static constexpr unsigned kIndicators = 0, kFirstInput = 0, kInputs = 0;
  static void start(Numbers& n) { n.v[1] = n.v[3] = 1; }
  static int evaluate(Numbers& n) { return n.v[2] = -n.v[3] * n.v[1], 0; }
  static void indicate(const Numbers&, double*) {}
  static bool wants_event(const Numbers& n) { return n.v[4] != 0 && n.memory[0] == 0 && n.time >= n.v[4]; }
  static bool wants_end(const Numbers&) { return false; }
  static Event update(Numbers& n) {
    if (!wants_event(n)) return {};
    n.v[1] += 1, n.memory[0] = 1;
    return {.states_changed = true};
  }
  static double partial(const Numbers& n, unsigned, unsigned) { return -n.v[3]; }
};

// x0' = x1, x1' = mu (1 - x0²) x1 - x0.
struct VanDerPol {
  static constexpr unsigned kStates[] = {1, 3}, kDerivatives[] = {2, 4}, kCount = 6;
  static constexpr unsigned kIndicators = 0, kFirstInput = 0, kInputs = 0;
  static void start(Numbers& n) { n.v[1] = 2, n.v[5] = 1; }
  static int evaluate(Numbers& n) {
    n.v[2] = n.v[3];
    n.v[4] = n.v[5] * (1 - n.v[1] * n.v[1]) * n.v[3] - n.v[1];
    return 0;
  }
  static void indicate(const Numbers&, double*) {}
  static bool wants_event(const Numbers&) { return false; }
  static bool wants_end(const Numbers&) { return false; }
  static Event update(Numbers&) { return {}; }
  static double partial(const Numbers& n, unsigned of, unsigned by) {
    if (of == 2) return by == 3 ? 1 : 0;
    return by == 1 ? -2 * n.v[5] * n.v[1] * n.v[3] - 1 : n.v[5] * (1 - n.v[1] * n.v[1]);
  }
};

// h' = v, v' = g. Where h passes zero downwards: v := -e v; below 0.1 m/s the ball rests.
struct BouncingBall {
  static constexpr unsigned kStates[] = {1, 3}, kDerivatives[] = {2, 4}, kCount = 8;
  static constexpr unsigned kIndicators = 1, kFirstInput = 0, kInputs = 0;
  static void start(Numbers& n) { n.v[1] = 1, n.v[5] = -9.81, n.v[6] = 0.7, n.v[7] = 0.1; }
  static int evaluate(Numbers& n) { return n.v[2] = n.v[3], n.v[4] = n.v[5], 0; }
  static void indicate(const Numbers& n, double* z) {
    *z = n.v[1] > -1e-10 && n.v[1] <= 0 && n.v[3] > 0 ? -1e-10 : n.v[1];
  }
  static bool wants_event(const Numbers&) { return false; }
  static bool wants_end(const Numbers&) { return false; }
  static Event update(Numbers& n) {
    if (!(n.v[1] <= 0 && n.v[3] < 0)) return {};
    n.v[1] = 2.2250738585072014e-308, n.v[3] *= -n.v[6];
    if (n.v[3] < n.v[7]) n.v[3] = n.v[5] = 0;
    return {.states_changed = true};
  }
  static double partial(const Numbers&, unsigned, unsigned) { return NAN; }
};

// Counts the seconds, from 1, and ends at 10.
struct Stair {
  static constexpr unsigned kStates[] = {0}, kDerivatives[] = {0}, kCount = 2;
  static constexpr unsigned kIndicators = 0, kFirstInput = 0, kInputs = 0;
  static void start(Numbers& n) { n.v[1] = 1; }
  static int evaluate(Numbers&) { return 0; }
  static void indicate(const Numbers&, double*) {}
  static bool wants_event(const Numbers&) { return false; }
  static bool wants_end(const Numbers&) { return false; }
  static Event update(Numbers& n) {
    if (n.time >= n.v[1]) n.v[1] += 1;  // the counter is the next whole second
    return {.terminate = n.v[1] >= 10, .has_next = true, .next = n.v[1]};
  }
  static double partial(const Numbers&, unsigned, unsigned) { return NAN; }
};

// wanted = kp e + ki I - kd speed,  e = target - angle,  I' = e;  torque: `current` with lag current' = (wanted -
// current) / lag, or without (lag = 0) what is wanted. Values 1, 2, 3: angle, speed, target; 4: torque; 5, 6: I, I';
// 7, 8, 9: gains; 10, 11: current, current'; 12: lag; 13: a fault after 0.1 s: 1 gives NaN, 2 an error, 3 discards, 4
// ends.
struct Drive {
  static constexpr unsigned kStates[] = {5, 10}, kDerivatives[] = {6, 11}, kCount = 14;
  static constexpr unsigned kIndicators = 0, kFirstInput = 1, kInputs = 3;
  static void start(Numbers& n) { n.v[7] = 1; }
  static int evaluate(Numbers& n) {
    double* v = n.v;
    v[6] = v[3] - v[1];
    const double wanted = v[7] * v[6] + v[8] * v[5] - v[9] * v[2];
    v[11] = v[12] > 0 ? (wanted - v[10]) / v[12] : 0;
    v[4] = v[12] > 0 ? v[10] : wanted;
    if (n.time <= 0.1) return 0;
    if (v[13] == 1) v[6] = NAN;
    return v[13] == 2 ? 3 : v[13] == 3 ? 2 : 0;
  }
  static void indicate(const Numbers&, double*) {}
  static bool wants_event(const Numbers&) { return false; }
  static bool wants_end(const Numbers& n) { return n.v[13] == 4 && n.time > 0.1; }
  static Event update(Numbers&) { return {}; }
  static double partial(const Numbers& n, unsigned of, unsigned by) {
    const double* v = n.v;
    if (of == 6) return by == 1 ? -1 : by == 3 ? 1 : 0;
    const double wanted = by == 1 ? -v[7] : by == 2 ? -v[9] : by == 3 ? v[7] : by == 5 ? v[8] : 0;
    if (of == 11) return v[12] > 0 ? (wanted - (by == 10 ? 1 : 0)) / v[12] : 0;
    return v[12] > 0 ? (by == 10 ? 1 : 0) : wanted;
  }
};

// Six drives with targets of 0.4 rad, fixed gains 12, 40, 0.5 and one lag; `cross` of the next joint's current is
// wanted too. Each has besides: heat' = current² - heat, work' = current speed. Values 1 to 6: angles, 7 to 12: speeds;
// then of each joint torque, integral, its rate, current, its rate, heat, its rate, work, its rate; 67: lag; 68: cross.
struct Robot {
  static constexpr unsigned kStates[] = {14, 16, 18, 20, 23, 25, 27, 29, 32, 34, 36, 38,
                                         41, 43, 45, 47, 50, 52, 54, 56, 59, 61, 63, 65};
  static constexpr unsigned kDerivatives[] = {15, 17, 19, 21, 24, 26, 28, 30, 33, 35, 37, 39,
                                              42, 44, 46, 48, 51, 53, 55, 57, 60, 62, 64, 66};
  static constexpr unsigned kCount = 69, kIndicators = 0, kFirstInput = 1, kInputs = 12;
  static constexpr unsigned of_joint(unsigned j) { return 13 + 9 * (j % 6); }
  static void start(Numbers& n) { n.v[67] = 1; }
  static int evaluate(Numbers& n) {
    double* v = n.v;
    for (unsigned j = 0; j < 6; ++j) {
      double* own = v + of_joint(j);
      own[0] = own[3];
      own[2] = 0.4 - v[1 + j];
      own[4] = (12 * own[2] + 40 * own[1] - 0.5 * v[7 + j] + v[68] * v[of_joint(j + 1) + 3] - own[3]) / v[67];
      own[6] = own[3] * own[3] - own[5];
      own[8] = own[3] * v[7 + j];
    }
    return 0;
  }
  static void indicate(const Numbers&, double*) {}
  static bool wants_event(const Numbers&) { return false; }
  static bool wants_end(const Numbers&) { return false; }
  static Event update(Numbers&) { return {}; }
  static double partial(const Numbers& n, unsigned of, unsigned by) {
    const unsigned j = (of - 13) / 9, own = of_joint(j);
    const double current = n.v[own + 3];
    const auto is = [&](unsigned value, double is_this) { return by == value ? is_this : 0; };
    switch (of - own) {
      case 0:
        return is(own + 3, 1);
      case 2:
        return is(1 + j, -1);
      case 4:
        return (is(1 + j, -12) + is(own + 1, 40) + is(7 + j, -0.5) + is(of_joint(j + 1) + 3, n.v[68]) -
                is(own + 3, 1)) /
               n.v[67];
      case 6:
        return is(own + 3, 2 * current) - is(own + 5, 1);
      default:
        return is(own + 3, n.v[7 + j]) + is(7 + j, current);
    }
  }
};

}  // namespace models

namespace {

using models::Event, models::Mode, models::Numbers;
using Model = models::LITHE_TEST_MODEL;

struct Unit {
  Numbers numbers;
  void (*tell)(void* environment, int status, const char* message) = nullptr;
  void* environment = nullptr;
};
Unit& of(void* unit) { return *static_cast<Unit*>(unit); }
Numbers& numbers(void* unit) { return of(unit).numbers; }

constexpr int kStateCount = Model::kStates[0] == 0 ? 0 : sizeof Model::kStates / sizeof *Model::kStates;

int wrong(void* unit, const char* message) {
  if (of(unit).tell) of(unit).tell(of(unit).environment, 3, message);
  return 3;
}
int mode(void* unit, Mode from, Mode to) {
  if (numbers(unit).mode != from) return wrong(unit, "not in this mode");
  numbers(unit).mode = to;
  return 0;
}
// Entries of an array lie one after the other: FMI 3.0 names the first.
template <class Number>
int get(void* unit, const unsigned* references, std::size_t count, Number* values, std::size_t numbers_wanted) {
  if (numbers(unit).mode == Mode::instantiated) return wrong(unit, "nothing can be read yet");
  if (const int status = Model::evaluate(numbers(unit)); status != 0) return status;
  for (std::size_t i = 0, to = 0; i < count; ++i) {
    const std::size_t size = count == 1 ? numbers_wanted : 1;
    for (std::size_t k = 0; k < size; ++k) {
      if (references[i] + k >= Model::kCount) return wrong(unit, "no such variable");
      values[to++] = static_cast<Number>(numbers(unit).v[references[i] + k]);
    }
  }
  return 0;
}
template <class Number>
int set(void* unit, const unsigned* references, std::size_t count, const Number* values, std::size_t numbers_given) {
  for (std::size_t i = 0, from = 0; i < count; ++i) {
    // Of Drive alone: inputs angle and speed are one array, as are the gains.
    const std::size_t size = numbers_given == count ? 1 : references[i] == 1 ? 2 : references[i] == 7 ? 3 : 1;
    for (std::size_t k = 0; k < size; ++k) {
      const unsigned r = references[i] + static_cast<unsigned>(k);
      if (r >= Model::kCount || from >= numbers_given) return wrong(unit, "no such variable");
      if (numbers(unit).mode == Mode::continuous &&
          (r < Model::kFirstInput || r >= Model::kFirstInput + Model::kInputs))
        return wrong(unit, "a parameter is set in a run");
      numbers(unit).v[r] = static_cast<double>(values[from++]);
    }
  }
  return 0;
}
int set_time(void* unit, double time) {
  if (numbers(unit).mode != Mode::continuous && numbers(unit).mode != Mode::event) return wrong(unit, "no time yet");
  return numbers(unit).time = time, 0;
}
int set_states(void* unit, const double* x, std::size_t n) {
  if (numbers(unit).mode != Mode::continuous) return wrong(unit, "no states yet");
  if (n != kStateCount) return wrong(unit, "another number of states");
  for (std::size_t i = 0; i < n; ++i) numbers(unit).v[Model::kStates[i]] = x[i];
  return 0;
}
int get_at(void* unit, const unsigned* references, double* x, std::size_t n) {
  if (n != kStateCount) return wrong(unit, "another number of states");
  const int status = Model::evaluate(numbers(unit));
  if (status == 3) return wrong(unit, "the amplifier is too hot");
  for (std::size_t i = 0; i < n; ++i) x[i] = numbers(unit).v[references[i]];
  return status;
}
int get_indicators(void* unit, double* z, std::size_t n) {
  return n == Model::kIndicators ? Model::indicate(numbers(unit), z), 0 : wrong(unit, "another number of indicators");
}
template <class Boolean>
int complete(void* unit, Boolean* event, Boolean* terminate) {
  if (numbers(unit).mode != Mode::continuous) return wrong(unit, "no step yet");
  *event = Model::wants_event(numbers(unit)), *terminate = Model::wants_end(numbers(unit));
  return 0;
}
int differentiate(void* unit, const unsigned* unknown, std::size_t n, const unsigned* known, std::size_t m,
                  const double* seed, std::size_t seeds, double* out) {
  for (std::size_t i = 0; i < n; ++i) {
    out[i] = 0;
    std::size_t s = 0;
    for (std::size_t j = 0; j < m; ++j) {
      const std::size_t size = seeds > m && known[j] == 1 ? 2 : 1;
      for (std::size_t k = 0; k < size; ++k)
        if (seed[s++] != 0)
          out[i] += seed[s - 1] * Model::partial(numbers(unit), unknown[i], known[j] + static_cast<unsigned>(k));
    }
  }
  return 0;
}
int save(void* unit, void** state) { return *state = new Numbers(numbers(unit)), 0; }
int load(void* unit, void* state) { return numbers(unit) = *static_cast<Numbers*>(state), 0; }
int forget(void** state) {
  delete static_cast<Numbers*>(*state);
  return *state = nullptr, 0;
}
void* make(void (*tell)(void*, int, const char*), void* environment) {
  Unit* unit = new Unit;
  unit->tell = tell, unit->environment = environment;
  Model::start(unit->numbers);
  return unit;
}

}  // namespace

#define EXPORT extern "C" __attribute__((visibility("default")))

// ---- FMI 2.0 ----

namespace {
struct Callbacks2 {
  void (*logger)(void*, const char*, int, const char*, const char*, ...);
  void *allocate, *release, *finished, *environment;
};
void tell2(void* callbacks, int status, const char* message) {
  const auto* to = static_cast<const Callbacks2*>(callbacks);
  to->logger(to->environment, "model", status, "logStatusError", "%s", message);
}
struct Info2 {
  int again, terminate, nominals, states, has_next;
  double next;
};
}  // namespace

EXPORT void* fmi2Instantiate(const char*, int type, const char*, const char*, Callbacks2* callbacks, int, int) {
  return type == 0 ? make(tell2, callbacks) : nullptr;
}
EXPORT void fmi2FreeInstance(void* unit) { delete static_cast<Unit*>(unit); }
EXPORT int fmi2SetupExperiment(void* u, int, double, double start, int, double) { return numbers(u).time = start, 0; }
EXPORT int fmi2EnterInitializationMode(void* u) { return mode(u, Mode::instantiated, Mode::initialization); }
EXPORT int fmi2ExitInitializationMode(void* u) { return mode(u, Mode::initialization, Mode::event); }
EXPORT int fmi2EnterEventMode(void* u) { return mode(u, Mode::continuous, Mode::event); }
EXPORT int fmi2EnterContinuousTimeMode(void* u) { return mode(u, Mode::event, Mode::continuous); }
EXPORT int fmi2NewDiscreteStates(void* u, Info2* info) {
  if (numbers(u).mode != Mode::event) return wrong(u, "no event");
  const Event e = Model::update(numbers(u));
  *info = {e.again, e.terminate, 0, e.states_changed, e.has_next, e.next};
  return 0;
}
EXPORT int fmi2CompletedIntegratorStep(void* u, int, int* event, int* end) { return complete(u, event, end); }
EXPORT int fmi2SetTime(void* u, double time) { return set_time(u, time); }
EXPORT int fmi2SetContinuousStates(void* u, const double* x, std::size_t n) { return set_states(u, x, n); }
EXPORT int fmi2GetContinuousStates(void* u, double* x, std::size_t n) { return get_at(u, Model::kStates, x, n); }
EXPORT int fmi2GetDerivatives(void* u, double* x, std::size_t n) { return get_at(u, Model::kDerivatives, x, n); }
EXPORT int fmi2GetEventIndicators(void* u, double* z, std::size_t n) { return get_indicators(u, z, n); }
EXPORT int fmi2GetReal(void* u, const unsigned* r, std::size_t n, double* v) { return get(u, r, n, v, n); }
EXPORT int fmi2SetReal(void* u, const unsigned* r, std::size_t n, const double* v) { return set(u, r, n, v, n); }
EXPORT int fmi2GetInteger(void* u, const unsigned* r, std::size_t n, int* v) { return get(u, r, n, v, n); }
EXPORT int fmi2SetInteger(void* u, const unsigned* r, std::size_t n, const int* v) { return set(u, r, n, v, n); }
EXPORT int fmi2GetDirectionalDerivative(void* u, const unsigned* unknown, std::size_t n, const unsigned* known,
                                        std::size_t m, const double* seed, double* out) {
  return differentiate(u, unknown, n, known, m, seed, m, out);
}
EXPORT int fmi2GetFMUstate(void* unit, void** state) { return save(unit, state); }
EXPORT int fmi2SetFMUstate(void* unit, void* state) { return load(unit, state); }
EXPORT int fmi2FreeFMUstate(void*, void** state) { return forget(state); }
EXPORT int fmi2SerializedFMUstateSize(void*, void*, std::size_t* size) { return *size = sizeof(Numbers), 0; }
EXPORT int fmi2SerializeFMUstate(void*, void* state, char* bytes, std::size_t size) {
  return std::memcpy(bytes, state, size), 0;
}
EXPORT int fmi2DeSerializeFMUstate(void*, const char* bytes, std::size_t size, void** state) {
  *state = new Numbers;
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

EXPORT void* fmi3InstantiateModelExchange(const char*, const char*, const char*, bool, bool, void* environment,
                                          void (*message)(void*, int, const char*, const char*)) {
  return make(tell3, new Log3{environment, message});
}
EXPORT void fmi3FreeInstance(void* unit) {
  delete static_cast<Log3*>(of(unit).environment);
  delete static_cast<Unit*>(unit);
}
EXPORT int fmi3EnterInitializationMode(void* u, bool, double, double start, bool, double) {
  return numbers(u).time = start, mode(u, Mode::instantiated, Mode::initialization);
}
EXPORT int fmi3ExitInitializationMode(void* u) { return mode(u, Mode::initialization, Mode::event); }
EXPORT int fmi3EnterEventMode(void* u) { return mode(u, Mode::continuous, Mode::event); }
EXPORT int fmi3EnterContinuousTimeMode(void* u) { return mode(u, Mode::event, Mode::continuous); }
EXPORT int fmi3UpdateDiscreteStates(void* u, bool* again, bool* end, bool* nominals, bool* states, bool* has_next,
                                    double* next) {
  if (numbers(u).mode != Mode::event) return wrong(u, "no event");
  const Event e = Model::update(numbers(u));
  *again = e.again, *end = e.terminate, *nominals = false, *states = e.states_changed, *has_next = e.has_next;
  return *next = e.next, 0;
}
EXPORT int fmi3CompletedIntegratorStep(void* u, bool, bool* event, bool* end) { return complete(u, event, end); }
EXPORT int fmi3SetTime(void* u, double time) { return set_time(u, time); }
EXPORT int fmi3SetContinuousStates(void* u, const double* x, std::size_t n) { return set_states(u, x, n); }
EXPORT int fmi3GetContinuousStates(void* u, double* x, std::size_t n) { return get_at(u, Model::kStates, x, n); }
EXPORT int fmi3GetContinuousStateDerivatives(void* u, double* x, std::size_t n) {
  return get_at(u, Model::kDerivatives, x, n);
}
EXPORT int fmi3GetEventIndicators(void* u, double* z, std::size_t n) { return get_indicators(u, z, n); }
#define GET_AND_SET(TYPE, NUMBER)                                                                       \
  EXPORT int fmi3Get##TYPE(void* u, const unsigned* r, std::size_t n, NUMBER* v, std::size_t size) {    \
    return get(u, r, n, v, size);                                                                       \
  }                                                                                                     \
  EXPORT int fmi3Set##TYPE(void* u, const unsigned* r, std::size_t n, const NUMBER* v, std::size_t s) { \
    return set(u, r, n, v, s);                                                                          \
  }
GET_AND_SET(Float64, double)
GET_AND_SET(Int32, std::int32_t)
EXPORT int fmi3GetDirectionalDerivative(void* u, const unsigned* unknown, std::size_t n, const unsigned* known,
                                        std::size_t m, const double* seed, std::size_t seeds, double* out,
                                        std::size_t) {
  return differentiate(u, unknown, n, known, m, seed, seeds, out);
}
EXPORT int fmi3GetFMUState(void* unit, void** state) { return save(unit, state); }
EXPORT int fmi3SetFMUState(void* unit, void* state) { return load(unit, state); }
EXPORT int fmi3FreeFMUState(void*, void** state) { return forget(state); }
EXPORT int fmi3SerializedFMUStateSize(void*, void*, std::size_t* size) { return *size = sizeof(Numbers), 0; }
EXPORT int fmi3SerializeFMUState(void*, void* state, std::uint8_t* bytes, std::size_t size) {
  return std::memcpy(bytes, state, size), 0;
}
EXPORT int fmi3DeserializeFMUState(void*, const std::uint8_t* bytes, std::size_t size, void** state) {
  *state = new Numbers;
  return std::memcpy(*state, bytes, size), 0;
}
