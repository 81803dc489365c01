#include "engine/plugin/body_from_c.h"

#include <algorithm>
#include <limits>

#include "engine/assembly/batch_of.h"
#include "engine/base/error.h"

namespace lithe {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr int kMostCoordinates = 10'000'000, kMostOfBody = 10'000'000;

/// Entries of a lower triangle with n columns, by column, rows rising from the diagonal.
bool is_pattern(const int32_t* rows, const int32_t* columns, int32_t count, int32_t n) {
  if (count < n || !rows || !columns) return false;
  for (int32_t k = 0, column = -1; k < count; ++k) {
    const bool next = columns[k] == column + 1 && rows[k] == columns[k];
    const bool same = k > 0 && columns[k] == column && rows[k] > rows[k - 1];
    if ((!next && !same) || rows[k] >= n) return false;
    column = columns[k];
  }
  return columns[count - 1] == n - 1;
}

}  // namespace

BodyFromC::Cache::Cache(const BodyFromC& body) : theirs(nullptr, body.table_.destroy_cache) {
  if (body.coordinates_.frames > 1) rotations.resize(static_cast<std::size_t>(body.coordinates_.frames));
  ErrorText why;
  theirs.reset(body.table_.create_cache(body.object_.get(), why.text, sizeof why.text));
  if (!theirs) body.object_.fail(body, why);
}

BodyFromC::BodyFromC(Parameters parameters)
    : table_(parameters.type->table), object_(*parameters.type, parameters.values) {
  int32_t frames = 0, linear = 0;
  table_.coordinates(object_.get(), &frames, &linear);
  if (linear < 0 || linear > kMostCoordinates || frames < 0 || frames > kMostCoordinates / 7)
    throw SceneError(object_.description() + " has " + std::to_string(frames) + " frames and " +
                         std::to_string(linear) + " linear coordinates",
                     "", "its author is to fix coordinates()");
  coordinates_ = {.frames = frames, .linear = linear};
  if (frames > 1 && table_.frame_pairs) {
    const int32_t *first = nullptr, *second = nullptr;
    const int32_t pairs = table_.frame_pairs(object_.get(), &first, &second);
    if (pairs < 0 || pairs > std::int64_t{frames} * (frames - 1) / 2 || (pairs > 0 && (!first || !second)))
      throw SceneError(object_.description() + " couples " + std::to_string(pairs) + " pairs of its " +
                           std::to_string(frames) + " frames, or lists none of them",
                       "", "its author is to fix frame_pairs(): each pair once, both lists");
    for (int32_t i = 0; i < pairs; ++i) pairs_.push_back({first[i], second[i]});
    coordinates_.pairs = pairs_;
  }
  count_markers();
  const int32_t *rows = nullptr, *columns = nullptr;
  const int32_t count = table_.linear_pattern(object_.get(), &rows, &columns);
  if (count == 0) return;
  if (!is_pattern(rows, columns, count, linear))
    throw SceneError(object_.description() + " has a pattern of " + std::to_string(count) +
                         " entries that is not a lower triangle of " + std::to_string(linear) + " columns",
                     "", "its author is to fix Coordinates::pattern (linear_pattern in C): by column, diagonals first");
  using Indices = Eigen::Map<const Eigen::VectorXi>;
  pattern_ = {Indices(rows, count), Indices(columns, count)};
  coordinates_.pattern = &pattern_;
}

void BodyFromC::count_markers() {
  const int32_t count = table_.marker_count(object_.get());
  if (count < 0 || count > kMostOfBody)
    throw SceneError(object_.description() + " has " + std::to_string(count) + " markers", "",
                     "its author is to fix marker_count(): 0 to " + std::to_string(kMostOfBody));
  set_marker_count(count);
}

/// Calls a function of the table with the state as C sees it; false if it asks for a smaller step.
template <class Call>
bool BodyFromC::call(const BodyState& state, Call&& function) const {
  auto& cache = static_cast<Cache&>(*state.cache);
  ErrorText why;
  lithe_body_state s{};
  s.struct_size = sizeof s;
  s.q = state.q, s.v = state.v, s.cache = cache.theirs.get();
  s.error = why.text, s.error_size = sizeof why.text;
  const int32_t code = function(&s);
  if (code < 0) object_.fail(*this, why);
  return code == 0;
}

template <class Function, class... Place>
Marker BodyFromC::made_marker(Function function, const char* where_at, const Place&... place) {
  const std::string type = "'" + name() + "': " + object_.description();
  if (!function) {
    std::string known;
    if (table_.place_marker) known += " marker(position)";
    if (table_.node_marker) known += " node(number)";
    if (table_.average_marker) known += " average({nodes})";
    throw SceneError(type + " has no markers at " + where_at, where(),
                     known.empty() ? "see what its author says of its markers" : "it has" + known);
  }
  ErrorText why;
  const int32_t index = function(object_.get(), place..., why.text, sizeof why.text);
  if (index < 0)
    throw SceneError(type + " refuses a marker: " + why.problem(), where(),
                     why.fix().empty() ? "see what its author says of its markers" : why.fix());
  count_markers();
  if (index >= marker_count())
    throw SceneError(type + " made marker " + std::to_string(index) + " and has " + std::to_string(marker_count()),
                     where(), "its author is to fix marker_count(): it counts those that were made");
  return {this, index};
}

Marker BodyFromC::marker(const Point& position, const Matrix3& orientation) {
  return made_marker(table_.place_marker, "positions", position.at.data(), orientation.data());
}

Marker BodyFromC::marker_at_world(const Point& point, const Matrix3& orientation) {
  if (coordinates_.frames != 1)
    throw SceneError(
        "'" + name() + "' has " + (coordinates_.frames == 0 ? "no frame" : "several frames") + " to place a marker in",
        where(), "make its markers at nodes");
  VectorX q(coordinates_.q_count()), v(coordinates_.v_count());
  initial_state(q, v);
  const Matrix3 A = rotation_matrix(q.segment<4>(3));
  return marker(A.transpose() * (point.at - q.head<3>()), A.transpose() * orientation);
}

Marker BodyFromC::node(int number, const Matrix3& orientation) {
  return made_marker(table_.node_marker, "nodes", number, orientation.data());
}

Marker BodyFromC::average(const std::vector<int>& nodes, const Matrix3& orientation) {
  return made_marker(table_.average_marker, "means of nodes", nodes.data(), static_cast<int32_t>(nodes.size()),
                     orientation.data());
}

void BodyFromC::initial_state(VectorRef q, VectorRef v) const {
  ErrorText why;
  if (table_.initial_state(object_.get(), q.data(), v.data(), why.text, sizeof why.text) != 0)
    throw SceneError("'" + name() + "': " + object_.description() + " has no initial state: " + why.problem(), where(),
                     why.fix().empty() ? "see what its author says" : why.fix());
}

void BodyFromC::evaluate(const BodyState& state, Level level) const {
  auto& cache = static_cast<Cache&>(*state.cache);
  cache.retry = !call(state, [&](const lithe_body_state* s) {
    return table_.evaluate(object_.get(), s, static_cast<int32_t>(level), cache.A.data());
  });
  for (std::size_t i = 0; i < cache.rotations.size(); ++i)
    cache.rotations[i] = rotation_matrix(Eigen::Map<const Vector4>(state.q + 7 * i + 3));
}

void BodyFromC::add_residual(const BodyState& state, const double* v_dot, const Vector3& gravity, double* r) const {
  const bool fine = !static_cast<Cache&>(*state.cache).retry && call(state, [&](const lithe_body_state* s) {
    return table_.add_residual(object_.get(), s, v_dot, gravity.data(), r);
  });
  if (!fine) Eigen::Map<VectorX>(r, coordinates_.v_count()).setConstant(kNaN);
}

void BodyFromC::add_tangent(const BodyState& state, const double* v_dot, const Vector3& gravity,
                            const TangentWeights& weights, BodyTangent& S) const {
  const lithe_tangent_weights w{weights.position, weights.velocity, weights.acceleration};
  const lithe_body_tangent out{sizeof out,
                               S.frame.data(),
                               S.frame_linear.data(),
                               S.linear_frame.data(),
                               S.linear.data(),
                               static_cast<int32_t>(S.linear.size()),
                               S.values,
                               reinterpret_cast<const int32_t*>(S.pairs.data()),
                               static_cast<int32_t>(S.pairs.size())};
  call(state, [&](const lithe_body_state* s) {  // a residual of NaN asks for the smaller step
    return table_.add_tangent(object_.get(), s, v_dot, gravity.data(), &w, &out);
  });
}

void BodyFromC::marker_kinematics(const BodyState& state, int marker, Level level, MarkerKinematics& k) const {
  lithe_marker_kinematics out{};
  out.struct_size = sizeof out;
  const bool fine = call(state, [&](const lithe_body_state* s) {
    return table_.marker_kinematics(object_.get(), s, marker, static_cast<int32_t>(level), &out);
  });
  if (!fine) std::fill_n(out.motion.p, 3, kNaN);  // asks for the smaller step
  const auto read = [](const double* from) { return Eigen::Map<const Vector3>(from); };
  k.p = read(out.motion.p);
  k.R = Eigen::Map<const Matrix3>(out.motion.R);
  k.r = read(out.r);
  k.A = &state.cache->A;
  k.elastic = out.elastic;
  if (coordinates_.frames > 1) {
    if (out.frame < 0 || out.frame >= coordinates_.frames)
      throw SceneError("'" + name() + "': " + object_.description() + " has marker " + std::to_string(marker) +
                           " in frame " + std::to_string(out.frame) + " of " + std::to_string(coordinates_.frames),
                       where(), "its author is to fix marker_kinematics()");
    k.frame = out.frame;
    k.A = &static_cast<Cache&>(*state.cache).rotations[static_cast<std::size_t>(out.frame)];
  }
  if (level == Level::position) return;
  k.v = read(out.motion.v);
  k.w = read(out.motion.w);
  if (level == Level::velocity) return;
  k.bias_v = read(out.bias_v);
  k.bias_w = read(out.bias_w);
}

BodyEnergy BodyFromC::energy(const BodyState& state, const Vector3& gravity) const {
  lithe_body_energy e{};
  if (!call(state, [&](const lithe_body_state* s) { return table_.energy(object_.get(), s, gravity.data(), &e); }))
    e.kinetic = kNaN;
  return {.kinetic = e.kinetic, .elastic = e.elastic, .gravity = e.gravity};
}

template std::unique_ptr<BodyBatch> make_body_batch<BodyFromC>();

}  // namespace lithe
