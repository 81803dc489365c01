#pragma once

#include <array>
#include <cmath>
#include <cstring>
#include <span>
#include <utility>

#include "engine/base/checks.h"
#include "engine/base/error.h"
#include "engine/base/parameters.h"
#include "engine/model/constraint.h"
#include "engine/model/force_element.h"
#include "engine/plugin_abi.h"

/// Writes the C tables of plugin_abi.h from C++ classes: joints and forces, and the parts that bodies and integrators
/// share with them.
namespace lithe::plugin {

/// What a guarded function returns.
enum Outcome : int32_t { kFine = 0, kRetry = 1, kFatal = -1 };

inline void write_error(char* error, size_t size, const std::string& problem, const std::string& fix = "") {
  if (!error || size == 0) return;
  const std::string text = fix.empty() ? problem : problem + "\n" + fix;
  const size_t length = std::min(size - 1, text.size());
  std::memcpy(error, text.data(), length);
  error[length] = 0;
}

/// Runs f at the C interface: no exception crosses it, only its text.
template <class F>
int32_t guarded(char* error, size_t size, F&& f) noexcept {
  try {
    return f();
  } catch (const Error& e) {
    write_error(error, size, e.problem(), e.fix());
  } catch (const std::exception& e) {
    write_error(error, size, e.what());
  } catch (...) {
    write_error(error, size, "it threw what is no std::exception");
  }
  return kFatal;
}

// ---- parameters ----

template <class T>
concept HasFields = requires {
  T::kParameters;
};

template <class Parameters>
lithe_field describe(const Field<Parameters>& field) {
  constexpr int32_t kKinds[] = {LITHE_NUMBER, LITHE_NUMBER, LITHE_NUMBER, LITHE_TEXT,  LITHE_TEXT,
                                LITHE_VECTOR, LITHE_VECTOR, LITHE_VECTOR, LITHE_VECTOR};
  constexpr int32_t kSizes[] = {0, 0, 0, 0, 0, 3, 9, 0, 0};
  return {field.name, kKinds[field.member.index()], kSizes[field.member.index()]};
}

/// The fields of a class, alive as long as the library.
template <class T>
std::span<const lithe_field> fields_of() {
  if constexpr (HasFields<T>) {
    static const auto fields = [] {
      std::array<lithe_field, std::size(T::kParameters)> all;
      for (size_t i = 0; i < all.size(); ++i) all[i] = describe(T::kParameters[i]);
      return all;
    }();
    return fields;
  } else {
    return {};
  }
}

inline void assign(double& to, const lithe_parameter& from) { to = from.number; }
inline void assign(int& to, const lithe_parameter& from) {
  to = static_cast<int>(from.number);
  if (to != from.number)
    throw SceneError(std::string(from.name) + " is " + std::to_string(from.number), "", "give a whole number");
}
inline void assign(bool& to, const lithe_parameter& from) {
  if (from.number != 0 && from.number != 1)
    throw SceneError(std::string(from.name) + " is " + std::to_string(from.number), "", "give true or false");
  to = from.number == 1;
}
inline void assign(std::string& to, const lithe_parameter& from) { to = from.text; }
inline void assign(std::filesystem::path& to, const lithe_parameter& from) { to = from.text; }
inline void assign(Vector3& to, const lithe_parameter& from) { to = Eigen::Map<const Vector3>(from.vector); }
inline void assign(Matrix3& to, const lithe_parameter& from) { to = Eigen::Map<const Matrix3>(from.vector); }
inline void assign(VectorX& to, const lithe_parameter& from) { to = Eigen::Map<const VectorX>(from.vector, from.size); }
inline void assign(std::vector<double>& to, const lithe_parameter& from) {
  to.assign(from.vector, from.vector + from.size);
}

/// A new T from parameters by name; throws what its constructor throws.
template <class T>
T* make(const lithe_parameter* given, size_t count) {
  if constexpr (HasFields<T>) {
    typename T::Parameters parameters;
    for (const lithe_parameter& p : std::span(given, count))
      for (const auto& field : T::kParameters)
        if (std::strcmp(field.name, p.name) == 0)
          std::visit([&](auto member) { assign(parameters.*member, p); }, field.member);
    return new T(std::move(parameters));
  } else if constexpr (requires { typename T::Parameters; }) {
    return new T(typename T::Parameters{});
  } else {
    return new T;
  }
}

template <class T>
void* create(const lithe_parameter* given, size_t count, char* error, size_t size) noexcept {
  T* made = nullptr;
  guarded(error, size, [&] { return made = make<T>(given, count), kFine; });
  return made;
}
template <class T>
void destroy(void* object) noexcept {
  delete static_cast<T*>(object);
}

/// The head that all tables share.
template <class T, class Table>
Table table_of(const char* name) {
  Table table{};
  table.struct_size = sizeof(Table);
  table.name = name;
  table.fields = fields_of<T>().data();
  table.field_count = fields_of<T>().size();
  table.create = create<T>;
  table.destroy = destroy<T>;
  return table;
}

// ---- joints and forces ----

/// Views of C markers as the classes see them.
template <int Count>
class Views {
 public:
  explicit Views(const lithe_marker* markers) : Views(markers, std::make_index_sequence<Count>{}) {}
  operator std::span<const MarkerView>() const { return views_; }

 private:
  template <size_t... I>
  Views(const lithe_marker* markers, std::index_sequence<I...>)
      : kinematics_{kinematics(markers[I])...}, views_{MarkerView(kinematics_[I], I)...} {}
  static MarkerKinematics kinematics(const lithe_marker& m) {
    MarkerKinematics k;
    k.p = Eigen::Map<const Vector3>(m.p);
    k.R = Eigen::Map<const Matrix3>(m.R);
    k.v = Eigen::Map<const Vector3>(m.v);
    k.w = Eigen::Map<const Vector3>(m.w);
    return k;
  }
  MarkerKinematics kinematics_[Count];
  MarkerView views_[Count];
};

template <class Matrix>
void write_numbers(const Matrix& from, double* to) {
  std::memcpy(to, from.data(), sizeof from);
}
inline void write_wrench(const Wrench& w, double* to) {
  write_numbers(w.force, to);
  write_numbers(w.torque, to + 3);
}

/// Rows that hold NaN ask for a smaller step, compiled in or loaded.
inline Outcome finite_or_retry(const double* values, int count) {
  for (int i = 0; i < count; ++i)
    if (!std::isfinite(values[i])) return kRetry;
  return kFine;
}

template <class T>
int32_t initialize(void* element, const lithe_marker* markers, char* error, size_t size) noexcept {
  return guarded(error, size, [&] {
    static_cast<T*>(element)->initialize(Views<T::kMarkers>(markers));
    return kFine;
  });
}

template <class T>
int32_t angles(const void* element, lithe_measured_angle* out, int32_t capacity) noexcept {
  int32_t count = 0;
  guarded(nullptr, 0, [&] {
    for (const MeasuredAngle& a : static_cast<const T*>(element)->angles())
      if (count++ < capacity) out[count - 1] = {a.A, a.B, a.axis, a.to_point};
    return kFine;
  });
  return count;
}

inline void check_rows(int written, int promised) {
  if (written != promised)
    throw SceneError("it wrote " + std::to_string(written) + " rows and promised " + std::to_string(promised), "",
                     "let evaluate() write as many rows as its class says");
}

template <class T>
int32_t evaluate_joint(const void* joint, double time, const lithe_marker* markers, lithe_rows* out) noexcept {
  return guarded(out->error, out->error_size, [&] {
    constexpr int n = T::kMarkers;
    ConstraintRows rows(n);
    ConstraintRows::Stiffness K;
    if (out->multipliers) {
      K.setZero(6 * n, 6 * n);
      rows.collect_stiffness(out->multipliers, &K);
    }
    rows.recall(out->quarter_turns);
    static_cast<const T*>(joint)->T::evaluate(time, Views<n>(markers), rows);
    check_rows(rows.count(), T::kRows);
    for (int r = 0; r < T::kRows; ++r) {
      out->residual[r] = rows.residual(r);
      out->rate[r] = rows.rate(r);
      out->bias[r] = rows.bias(r);
      out->on_velocity[r] = rows.on_velocity(r);
      for (int m = 0; m < n; ++m) write_wrench(rows.wrench(r, m), out->wrench + 6 * (n * r + m));
    }
    out->no_stiffness = rows.written();
    if (out->stiffness) Eigen::Map<MatrixX>(out->stiffness, 6 * n, 6 * n) += K;
    return std::max(finite_or_retry(out->residual, T::kRows), finite_or_retry(out->bias, T::kRows));
  });
}

template <class T>
int32_t evaluate_force(const void* force, double time, const lithe_marker* markers, lithe_force_rows* out) noexcept {
  return guarded(out->error, out->error_size, [&] {
    constexpr int n = T::kMarkers;
    ForceRows rows(n);
    rows.recall(out->quarter_turns);
    static_cast<const T*>(force)->T::evaluate(time, Views<n>(markers), rows);
    check_rows(rows.count(), T::kRows);
    for (int m = 0; m < n; ++m) write_wrench(rows.load(m), out->load + 6 * m);
    for (int r = 0; r < T::kRows; ++r) {
      out->tension[r] = rows.tension(r);
      out->stiffness[r] = rows.stiffness(r);
      out->damping[r] = rows.damping(r);
      for (int m = 0; m < n; ++m) write_wrench(rows.wrench(r, m), out->wrench + 6 * (n * r + m));
    }
    out->energy = rows.energy();
    return std::max(finite_or_retry(out->load, 6 * n), finite_or_retry(out->tension, T::kRows));
  });
}

template <class T>
lithe_joint_type joint_type(const char* name) {
  static_assert(T::kMarkers <= kMaxMarkers && T::kRows <= kMaxRows, "a joint has at most 8 markers and 12 rows");
  auto table = table_of<T, lithe_joint_type>(name);
  table.marker_count = T::kMarkers;
  table.row_count = T::kRows;
  table.initialize = initialize<T>;
  table.evaluate = evaluate_joint<T>;
  table.angles = angles<T>;
  return table;
}

template <class T>
lithe_force_type force_type(const char* name) {
  static_assert(T::kMarkers <= kMaxMarkers && T::kRows <= kMaxRows, "a force has at most 8 markers and 12 rows");
  auto table = table_of<T, lithe_force_type>(name);
  table.marker_count = T::kMarkers;
  table.row_count = T::kRows;
  table.initialize = initialize<T>;
  table.evaluate = evaluate_force<T>;
  table.angles = angles<T>;
  return table;
}

}  // namespace lithe::plugin
