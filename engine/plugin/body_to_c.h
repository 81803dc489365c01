#pragma once

#include "engine/model/body.h"
#include "engine/plugin/plugin_tables.h"

/// Writes the C table of a body from its class.
namespace lithe::plugin {

template <class T>
const T& body_of(const void* body) {
  return *static_cast<const T*>(body);
}
template <class T>
BodyState state_of(const lithe_body_state* s) {
  return {s->q, s->v, static_cast<typename T::Cache*>(s->cache)};
}

template <class T>
void coordinates(const void* body, int32_t* frames, int32_t* linear) noexcept {
  const Coordinates c = body_of<T>(body).coordinates();
  *frames = c.frames;
  *linear = c.linear;
}

template <class T>
int32_t linear_pattern(const void* body, const int32_t** rows, const int32_t** columns) noexcept {
  const LinearPattern* pattern = body_of<T>(body).coordinates().pattern;
  if (!pattern) return 0;
  *rows = pattern->rows.data();
  *columns = pattern->columns.data();
  return static_cast<int32_t>(pattern->rows.size());
}

template <class T>
int32_t frame_pairs(const void* body, const int32_t** firsts, const int32_t** seconds) noexcept {
  // The border has two arrays where the class has one of pairs; kept for as long as the thread lives or asks again.
  thread_local std::vector<int32_t> first, second;
  first.clear(), second.clear();
  for (const FramePair& p : body_of<T>(body).coordinates().pairs) first.push_back(p.first), second.push_back(p.second);
  *firsts = first.data(), *seconds = second.data();
  return static_cast<int32_t>(first.size());
}

/// Index of the marker that `make` makes, or kFatal.
template <class Make>
int32_t marker_index(char* error, size_t size, Make&& make) noexcept {
  return guarded(error, size, [&]() -> int32_t { return make().index; });
}
template <class T>
int32_t place_marker(void* body, const double* position, const double* orientation, char* error, size_t size) noexcept {
  return marker_index(error, size, [&] {
    return static_cast<T*>(body)->marker(Point(Eigen::Map<const Vector3>(position)),
                                         Matrix3(Eigen::Map<const Matrix3>(orientation)));
  });
}
template <class T>
int32_t node_marker(void* body, int32_t node, const double* orientation, char* error, size_t size) noexcept {
  return marker_index(
      error, size, [&] { return static_cast<T*>(body)->node(node, Matrix3(Eigen::Map<const Matrix3>(orientation))); });
}
template <class T>
int32_t average_marker(void* body, const int32_t* nodes, int32_t count, const double* orientation, char* error,
                       size_t size) noexcept {
  return marker_index(error, size, [&] {
    return static_cast<T*>(body)->average(std::vector<int>(nodes, nodes + count),
                                          Matrix3(Eigen::Map<const Matrix3>(orientation)));
  });
}
template <class T>
int32_t marker_count(const void* body) noexcept {
  return body_of<T>(body).marker_count();
}

template <class T>
int32_t initial_state(const void* body, double* q, double* v, char* error, size_t size) noexcept {
  return guarded(error, size, [&] {
    const Coordinates c = body_of<T>(body).coordinates();
    body_of<T>(body).initial_state(Eigen::Map<VectorX>(q, c.q_count()), Eigen::Map<VectorX>(v, c.v_count()));
    return kFine;
  });
}

template <class T>
void* create_cache(const void* body, char* error, size_t size) noexcept {
  typename T::Cache* cache = nullptr;
  guarded(error, size, [&] { return cache = new typename T::Cache(body_of<T>(body)), kFine; });
  return cache;
}

template <class T>
int32_t evaluate_body(const void* body, const lithe_body_state* s, int32_t level, double* rotation) noexcept {
  return guarded(s->error, s->error_size, [&] {
    const BodyState state = state_of<T>(s);
    body_of<T>(body).T::evaluate(state, static_cast<Level>(level));
    write_numbers(state.cache->A, rotation);
    return kFine;
  });
}

template <class T>
int32_t add_residual(const void* body, const lithe_body_state* s, const double* v_dot, const double* gravity,
                     double* r) noexcept {
  return guarded(s->error, s->error_size, [&] {
    body_of<T>(body).T::add_residual(state_of<T>(s), v_dot, Eigen::Map<const Vector3>(gravity), r);
    return kFine;
  });
}

template <class T>
int32_t add_tangent(const void* body, const lithe_body_state* s, const double* v_dot, const double* gravity,
                    const lithe_tangent_weights* weights, const lithe_body_tangent* out) noexcept {
  return guarded(s->error, s->error_size, [&] {
    const Coordinates c = body_of<T>(body).coordinates();
    const int coupled = c.frames > 0 ? c.linear : 0;
    BodyTangent S{Eigen::Map<Matrix6>(out->frame), Eigen::Map<Matrix6X>(out->frame_linear, 6, coupled),
                  Eigen::Map<MatrixX>(out->linear_frame, coupled, 6),
                  Eigen::Map<VectorX>(out->linear, out->linear_count)};
    if (c.frames > 1) {  // a host that knows no such bodies has refused this one
      S.values = out->pair_values;
      S.pairs = {reinterpret_cast<const BodyTangent::PairPlace*>(out->pair_places),
                 static_cast<std::size_t>(out->pair_count)};
    }
    body_of<T>(body).T::add_tangent(state_of<T>(s), v_dot, Eigen::Map<const Vector3>(gravity),
                                    {weights->position, weights->velocity, weights->acceleration}, S);
    return kFine;
  });
}

template <class T>
int32_t marker_kinematics(const void* body, const lithe_body_state* s, int32_t marker, int32_t level,
                          lithe_marker_kinematics* out) noexcept {
  return guarded(s->error, s->error_size, [&] {
    MarkerKinematics k;
    for (Vector3* x : {&k.v, &k.w, &k.bias_v, &k.bias_w}) x->setZero();  // not written at lower levels
    body_of<T>(body).T::marker_kinematics(state_of<T>(s), marker, static_cast<Level>(level), k);
    write_numbers(k.p, out->motion.p);
    write_numbers(k.R, out->motion.R);
    write_numbers(k.v, out->motion.v);
    write_numbers(k.w, out->motion.w);
    write_numbers(k.bias_v, out->bias_v);
    write_numbers(k.bias_w, out->bias_w);
    write_numbers(k.r, out->r);
    out->elastic = k.elastic;
    if (k.between)
      throw SceneError("marker " + std::to_string(marker) + " moves with two frames", "",
                       "make markers of plug-ins in one frame: such a marker does not cross the border");
    if (k.frame != 0) out->frame = k.frame;  // a host that does not know it has no bodies with several frames
    return kFine;
  });
}

template <class T>
int32_t energy(const void* body, const lithe_body_state* s, const double* gravity, lithe_body_energy* out) noexcept {
  return guarded(s->error, s->error_size, [&] {
    const BodyEnergy e = body_of<T>(body).T::energy(state_of<T>(s), Eigen::Map<const Vector3>(gravity));
    *out = {e.kinetic, e.elastic, e.gravity};
    return kFine;
  });
}

template <class T>
lithe_body_type body_type(const char* name) {
  auto table = table_of<T, lithe_body_type>(name);
  table.coordinates = coordinates<T>;
  table.linear_pattern = linear_pattern<T>;
  if constexpr (requires(T & body) { body.marker(Point{}, Matrix3{}).index; }) table.place_marker = place_marker<T>;
  if constexpr (requires(T & body) { body.node(1, Matrix3{}).index; }) table.node_marker = node_marker<T>;
  if constexpr (requires(T & body) { body.average(std::vector<int>{}, Matrix3{}).index; })
    table.average_marker = average_marker<T>;
  table.marker_count = marker_count<T>;
  table.initial_state = initial_state<T>;
  table.create_cache = create_cache<T>;
  table.destroy_cache = destroy<typename T::Cache>;
  table.evaluate = evaluate_body<T>;
  table.add_residual = add_residual<T>;
  table.add_tangent = add_tangent<T>;
  table.marker_kinematics = marker_kinematics<T>;
  table.energy = energy<T>;
  table.frame_pairs = frame_pairs<T>;
  return table;
}

}  // namespace lithe::plugin
