// The C border of plug-ins: tables whose sizes, names, functions, numbers and return values the input chooses. A scene
// with such a type is refused by lithe::Error, or runs and leaves a state that is finite. What no host can see is left
// out: pointers to nowhere, and writing beyond an array.
#include <algorithm>

#include "bodies/rigid_body.h"
#include "engine/plugin/registry.h"
#include "engine/run/simulation.h"
#include "integrators/explicit_runge_kutta.h"
#include "integrators/generalized_alpha.h"
#include "tools/fuzz/script.h"
#include "tools/fuzz/targets.h"

namespace lithe::fuzz {
namespace {

/// The plug-in of this input; its functions get nothing else to know it by.
FuzzScript* script = nullptr;
char object;  // what create() returns

// ---- what all kinds have ----

/// Why, perhaps without its closing zero.
int32_t code(char* error, size_t size) {
  const int32_t result = script->integer(0);
  if (result != 0 && error && size > 0 && script->odd()) std::fill_n(error, size, 'x');
  return result;
}

void* create(const lithe_parameter*, size_t, char* error, size_t size) {
  return code(error, size) == 0 ? &object : nullptr;
}
void destroy(void*) {}

void fill(double* values, int count, double sane = 0) {
  for (int i = 0; i < count; ++i) values[i] = script->number(sane);
}

template <class Function>
Function* unless_odd(Function* function) {
  return script->odd() ? nullptr : function;
}

/// Bytes of a table: all, or fewer; never more than there are.
template <class Table>
size_t table_size() {
  return script->odd() ? script->raw<std::uint16_t>() % (sizeof(Table) + 1) : sizeof(Table);
}

template <class Table>
Table table() {
  static const lithe_field fields[] = {
      {"length", LITHE_NUMBER, 0}, {"axis", LITHE_VECTOR, 3}, {"file", LITHE_TEXT, 0}, {"length", LITHE_NUMBER, 0},
      {nullptr, LITHE_NUMBER, 0},  {"", LITHE_TEXT, 0},       {"odd", 7, 0},           {"odder", LITHE_VECTOR, -3}};
  static constexpr size_t kCounts[] = {0, 1, 2, 4, 5, 6, 7, 8};
  static constexpr const char* kNames[] = {"", nullptr, "\xff\xfe", "fuzzed\nfuzzed"};
  Table t{};
  t.struct_size = table_size<Table>();
  t.name = script->one_of<const char*>("fuzzed", kNames);
  t.field_count = script->one_of<size_t>(3, kCounts);
  t.fields = script->odd() ? nullptr : fields;
  t.create = unless_odd(create);
  t.destroy = unless_odd(destroy);
  return t;
}

int32_t angles(const void*, lithe_measured_angle* out, int32_t capacity) {
  const int32_t count = script->integer(1);
  for (int32_t i = 0; i < std::clamp(count, 0, capacity); ++i)
    out[i] = {script->integer(0), script->integer(1), script->integer(2), script->integer(0)};
  return count;
}
int32_t initialize(void*, const lithe_marker*, char* error, size_t size) { return code(error, size); }

// ---- a joint: three rows that hold a point, and a force ----

int32_t evaluate_joint(const void*, double, const lithe_marker* markers, lithe_rows* out) {
  for (int r = 0; r < out->row_count; ++r) {
    const int axis = r % 3;
    for (int m = 0; m < out->marker_count; ++m)
      for (int k = 0; k < 6; ++k)
        out->wrench[6 * (out->marker_count * r + m) + k] = script->number(k == axis ? (m == 0 ? -1 : m == 1) : 0);
    const double to = out->marker_count > 1 ? markers[1].p[axis] : 0;
    out->residual[r] = script->number(to - markers[0].p[axis]);
    out->rate[r] = script->number(0);
    out->bias[r] = script->number(0);
    out->on_velocity[r] = script->integer(0);
  }
  out->no_stiffness = script->integer(1);
  if (out->stiffness && script->odd()) fill(out->stiffness, 36 * out->marker_count * out->marker_count);
  return code(out->error, out->error_size);
}

int32_t evaluate_force(const void*, double, const lithe_marker* markers, lithe_force_rows* out) {
  fill(out->load, 6 * out->marker_count);
  for (int r = 0; r < out->row_count; ++r) {
    fill(out->wrench + 6 * out->marker_count * r, 6 * out->marker_count, r + 1);
    out->tension[r] = script->number(markers[0].p[2]);
    out->stiffness[r] = script->number(1);
    out->damping[r] = script->number(0.1);
  }
  out->energy = script->number(0);
  return code(out->error, out->error_size);
}

template <class Table, class Evaluate>
Table connector(Evaluate* evaluate, int rows) {
  auto t = table<Table>();
  t.marker_count = script->integer(2);
  t.row_count = script->integer(rows);
  t.initialize = unless_odd(initialize);
  t.evaluate = unless_odd(evaluate);
  t.angles = unless_odd(angles);
  return t;
}

// ---- a body: a point mass in frames, and masses beside it that move along one line each ----

struct HostileShape {
  int32_t frames = 1, linear = 2;
  int q() const { return 7 * frames + linear; }
  int v() const { return 6 * frames + linear; }
} shape;

void coordinates(const void*, int32_t* frames, int32_t* linear) {
  // Not so many as may be, but would fill the memory.
  static constexpr int32_t kOddOnes[] = {
      -1, 0, 1, 2, 3, std::numeric_limits<int32_t>::max(), std::numeric_limits<int32_t>::min(), 10'000'001};
  *frames = shape.frames = script->one_of<int32_t>(1, kOddOnes);
  *linear = shape.linear = script->one_of<int32_t>(2, kOddOnes);
}
/// Indices that are sane, or not, in arrays of the function's own.
constexpr int kMost = 16;
int32_t two_lists(int32_t sane, const int32_t* as_first, const int32_t* as_second, const int32_t** first,
                  const int32_t** second) {
  static int32_t lists[2][kMost];
  for (int i = 0; i < kMost; ++i)
    lists[0][i] = script->integer(as_first[i]), lists[1][i] = script->integer(as_second[i]);
  const int32_t count = script->integer(sane);
  const bool fits = count <= kMost;
  *first = fits && !script->odd() ? lists[0] : nullptr;
  *second = fits && !script->odd() ? lists[1] : nullptr;
  return count;
}
int32_t linear_pattern(const void*, const int32_t** rows, const int32_t** columns) {
  static constexpr int32_t kRows[kMost] = {0, 1, 1}, kColumns[kMost] = {0, 0, 1};
  return two_lists(script->byte() % 2 ? 3 : 0, kRows, kColumns, rows, columns);
}
int32_t frame_pairs(const void*, const int32_t** firsts, const int32_t** seconds) {
  static constexpr int32_t kFirsts[kMost] = {0, 0, 1}, kSeconds[kMost] = {1, 2, 2};
  return two_lists(script->byte() % 4, kFirsts, kSeconds, firsts, seconds);
}
int32_t place_marker(void*, const double*, const double*, char*, size_t) { return script->integer(0); }
int32_t node_marker(void*, int32_t, const double*, char*, size_t) { return script->integer(0); }
int32_t marker_count(const void*) { return script->integer(1); }
int32_t initial_state(const void*, double* q, double* v, char* error, size_t size) {
  for (int f = 0; f < shape.frames; ++f)
    for (int i = 0; i < 7; ++i) q[7 * f + i] = script->number(i == 3);
  fill(q + 7 * shape.frames, shape.linear);
  fill(v, shape.v());
  return code(error, size);
}
void* create_cache(const void*, char* error, size_t size) { return code(error, size) == 0 ? &object : nullptr; }
int32_t evaluate_body(const void*, const lithe_body_state* s, int32_t, double* rotation) {
  for (int i = 0; i < 9; ++i) rotation[i] = script->number(i % 4 == 0);
  return code(s->error, s->error_size);
}
int32_t add_residual(const void*, const lithe_body_state* s, const double* v_dot, const double* gravity, double* r) {
  for (int i = 0; i < shape.v(); ++i)
    r[i] += script->number(v_dot[i] - (i < 6 * shape.frames && i % 6 < 3 ? gravity[i % 6] : 0));
  return code(s->error, s->error_size);
}
int32_t add_tangent(const void*, const lithe_body_state* s, const double*, const double*,
                    const lithe_tangent_weights* weights, const lithe_body_tangent* out) {
  for (int f = 0; f < shape.frames; ++f)
    for (int i = 0; i < 6; ++i) out->frame[36 * f + 7 * i] += script->number(weights->acceleration);
  for (int i = 0; i < out->linear_count; ++i)
    if (out->linear_count == shape.linear || i != 1) out->linear[i] += script->number(weights->acceleration);
  return code(s->error, s->error_size);
}
int32_t marker_kinematics(const void*, const lithe_body_state* s, int32_t, int32_t, lithe_marker_kinematics* out) {
  static double elastic[6 * 4];
  if (shape.frames > 0) {
    std::copy_n(s->q, 3, out->motion.p);
    std::copy_n(s->v, 3, out->motion.v);
    std::copy_n(s->v + 3, 3, out->motion.w);
  }
  for (int i = 0; i < 9; ++i) out->motion.R[i] = script->number(i % 4 == 0);
  fill(out->r, 3);
  out->frame = script->integer(0);
  if (shape.linear <= 4 && script->odd()) fill(elastic, std::size(elastic)), out->elastic = elastic;
  return code(s->error, s->error_size);
}
int32_t body_energy(const void*, const lithe_body_state* s, const double*, lithe_body_energy* out) {
  *out = {script->number(1), script->number(1), script->number(1)};
  return code(s->error, s->error_size);
}

lithe_body_type body() {
  auto t = table<lithe_body_type>();
  t.coordinates = unless_odd(coordinates);
  t.linear_pattern = unless_odd(linear_pattern);
  t.place_marker = unless_odd(place_marker);
  t.node_marker = unless_odd(node_marker);
  t.marker_count = unless_odd(marker_count);
  t.initial_state = unless_odd(initial_state);
  t.create_cache = unless_odd(create_cache);
  t.destroy_cache = unless_odd(destroy);
  t.evaluate = unless_odd(evaluate_body);
  t.add_residual = unless_odd(add_residual);
  t.add_tangent = unless_odd(add_tangent);
  t.marker_kinematics = unless_odd(marker_kinematics);
  t.energy = unless_odd(body_energy);
  t.frame_pairs = unless_odd(frame_pairs);
  return t;
}

// ---- an integrator: Euler's method, which asks for odd things on its way ----

const lithe_equations* equations = nullptr;

int32_t start(void*, const lithe_equations* given, lithe_state* state, char* error, size_t size) {
  equations = given;
  state->time = script->number(state->time);
  return code(error, size);
}
int32_t step(void*, lithe_state* s, double t_stop, char* error, size_t size) {
  const lithe_equations& e = *equations;
  std::vector<double> next(static_cast<size_t>(e.q_count)), d(static_cast<size_t>(e.v_count)), rows(100),
      turns(static_cast<size_t>(std::max(s->quarter_turn_count, 0)));
  const double h = std::min(t_stop - s->time, 1e-3);
  if (const int32_t bad = e.evaluate(e.host, s->time, s->q, s->v, script->integer(LITHE_ACCELERATION))) return bad;
  if (const int32_t bad = e.constraint(e.host, script->integer(0), rows.data())) return bad;
  static constexpr int32_t kNone[] = {-1, 0, std::numeric_limits<int32_t>::min()};
  if (const int32_t bad = e.recall(e.host, turns.data(), script->one_of<int32_t>(s->quarter_turn_count, kNone)))
    return bad;
  if (script->odd()) {
    const lithe_complex_tangent_weights weights{{1, 1}, {1, 0}, {1, 0}};
    if (const int32_t bad = e.factorize_complex(e.host, &weights, s->v_dot, s->lambda, nullptr)) return bad;
  }
  if (script->odd()) {
    const lithe_tangent_weights weights{script->number(0), script->number(0), script->number(1)};
    if (const int32_t bad = e.factorize(e.host, &weights, s->v_dot, s->lambda, nullptr)) return bad;
  }
  for (int i = 0; i < e.v_count; ++i) d[static_cast<size_t>(i)] = h * script->number(s->v[i]);
  if (const int32_t bad = e.retract(e.host, s->q, d.data(), next.data())) return bad;
  std::copy(next.begin(), next.end(), s->q);
  s->time = script->number(s->time + h);
  return code(error, size);
}
void statistics(const void*, lithe_statistics* out) { out->steps = script->integer(1); }
int64_t save(void*, unsigned char* bytes, int64_t capacity) {
  static constexpr int64_t kSizes[] = {-1, 0, std::numeric_limits<int64_t>::max(), int64_t{1} << 40, 3};
  const int64_t size = script->one_of<int64_t>(8, kSizes);
  if (bytes) std::fill_n(bytes, std::clamp<int64_t>(size, 0, capacity), script->byte());
  return size;
}
int32_t load(void*, const lithe_state*, const unsigned char*, int64_t, char* error, size_t size) {
  return code(error, size);
}

lithe_integrator_type integrator() {
  auto t = table<lithe_integrator_type>();
  t.start = unless_odd(start);
  t.step = unless_odd(step);
  t.statistics = unless_odd(statistics);
  t.save = unless_odd(save);
  t.load = unless_odd(load);
  return t;
}

// ---- the scene ----

enum class HostileKind { joint, force, body, integrator } kind;

int32_t entry(const lithe_host* host) {
  const auto hand_over = [&](auto add, const auto& one) {
    add(host->context, script->odd() ? nullptr : &one);
    if (script->odd()) add(host->context, &one);
  };
  switch (kind) {
    case HostileKind::joint:
      hand_over(host->add_joint, connector<lithe_joint_type>(evaluate_joint, 3));
      break;
    case HostileKind::force:
      hand_over(host->add_force, connector<lithe_force_type>(evaluate_force, 1));
      break;
    case HostileKind::body:
      hand_over(host->add_body, body());
      break;
    case HostileKind::integrator:
      hand_over(host->add_integrator, integrator());
      break;
  }
  return script->integer(0);
}

ParameterList parameters() {
  ParameterList given;
  if (script->odd()) given.emplace_back("length", script->number(1));
  if (script->odd()) given.emplace_back("axis", std::vector<double>(script->byte() % 5u, 1.0));
  if (script->odd()) given.emplace_back("file", std::string("a"));
  return given;
}

void plugin_table(std::string_view input, const std::filesystem::path&) {
  FuzzScript words(input);
  script = &words;
  shape = {};
  kind = static_cast<HostileKind>(words.byte() % 4);
  Registry registry;
  registry.add_plugin("fuzzed", entry);
  SystemGraph graph{{.gravity = {0, 0, -9.81}}};
  auto& stone = graph.add<RigidBody>("stone", {.mass = 2, .inertia = {0.1, 0.2, 0.3}});
  std::vector<Marker> markers{graph.ground().marker(), stone.marker()};
  std::unique_ptr<Integrator> method;
  if (kind == HostileKind::joint) {
    const JointType& type = registry.joint("fuzzed");
    markers.resize(static_cast<size_t>(type.table.marker_count), stone.marker({0, 0.1, 0}));
    graph.add(type, "joint", markers, parameters());
  } else if (kind == HostileKind::force) {
    const ForceType& type = registry.force("fuzzed");
    markers.resize(static_cast<size_t>(type.table.marker_count), stone.marker({0, 0.1, 0}));
    graph.add(type, "force", markers, parameters());
  } else if (kind == HostileKind::body) {
    auto& body = graph.add(registry.body("fuzzed"), "body", parameters());
    if (words.odd()) body.marker({1, 0, 0});
    if (words.odd()) body.node(3);
    if (words.odd()) body.marker_at_world({0, 0, 1});
  } else {
    method = registry.integrator("fuzzed", parameters());
  }
  const System system = assemble(graph);
  State state = system.initial_state();
  if (!method && words.byte() % 2)
    method = std::make_unique<GeneralizedAlpha>(GeneralizedAlpha::Parameters{.step = 1e-3});
  if (!method) method = std::make_unique<ExplicitRungeKutta>(ExplicitRungeKutta::Parameters{.step = 1e-3});
  Simulation simulation(system, *method);
  simulation.run(state, 3e-3);
  demand(state.time == 3e-3 && state.q.allFinite() && state.v.allFinite(), "a run ends at a state that is not finite");
  const Sensor energy = total_energy();
  Snapshot now(system, state);
  (void)energy.value(now);
  Archive archive;
  simulation.save(state, archive);
  archive.rewind();
  state = simulation.resume(archive);
  simulation.run(state, 4e-3);
  demand(state.q.allFinite() && state.v.allFinite(), "a resumed run ends at a state that is not finite");
}

}  // namespace

std::vector<Target> plugin_targets() { return {{"plugin_table", plugin_table}}; }

}  // namespace lithe::fuzz
