#include "engine/plugin/connectors_from_c.h"

#include <algorithm>
#include <cstring>
#include <limits>

#include "engine/assembly/batch_of.h"
#include "engine/base/error.h"

namespace lithe {
namespace {

constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();

/// The markers as C sees them.
struct Markers {
  lithe_marker all[kMaxMarkers];
  explicit Markers(std::span<const MarkerView> views) {
    for (const MarkerView& view : views) {
      lithe_marker& m = all[view.index];
      const auto write = [](const auto& from, double* to) { std::memcpy(to, from.data(), sizeof from); };
      write(view.p, m.p);
      write(view.R, m.R);
      write(view.v, m.v);
      write(view.w, m.w);
    }
  }
};

Wrench wrench_at(const double* w) { return {Eigen::Map<const Vector3>(w), Eigen::Map<const Vector3>(w + 3)}; }

template <class Table>
void initialize_with(const Table& table, const PluginObject& object, std::span<const MarkerView> markers) {
  if (!table.initialize) return;
  ErrorText why;
  if (table.initialize(object.get(), Markers(markers).all, why.text, sizeof why.text) != 0)
    throw SceneError(object.description() + " refuses its markers as drawn: " + why.problem(), "",
                     why.fix().empty() ? "see what its author says of its markers" : why.fix());
}

std::vector<MeasuredAngle> angles_of(const auto& table, const PluginObject& object) {
  constexpr int kMost = 64;
  lithe_measured_angle written[kMost];
  std::vector<MeasuredAngle> angles;
  const int count = table.angles ? table.angles(object.get(), written, kMost) : 0;
  if (count < 0 || count > kMost)
    throw SceneError(object.description() + " measures " + std::to_string(count) + " angles", "",
                     "its author is to fix angles(): at most " + std::to_string(kMost));
  for (const lithe_measured_angle& a : std::span(written, count)) {
    const auto is_marker = [&](int m) { return m >= 0 && m < table.marker_count; };
    if (!is_marker(a.A) || !is_marker(a.B) || a.axis < 0 || a.axis > 2)
      throw SceneError(object.description() + " measures an angle between markers or about an axis that it has not", "",
                       "its author is to fix angles()");
    angles.push_back({a.A, a.B, a.axis, a.to_point != 0});
  }
  return angles;
}

}  // namespace

JointFromC::JointFromC(Parameters parameters)
    : table_(parameters.type->table),
      object_(*parameters.type, parameters.values),
      angles_(angles_of(table_, object_)) {}

void JointFromC::initialize(std::span<const MarkerView> markers) { initialize_with(table_, object_, markers); }

void JointFromC::evaluate(double time, std::span<const MarkerView> views, ConstraintRows& rows) const {
  const Markers markers(views);
  const int n = table_.marker_count;
  double residual[kMaxRows], rate[kMaxRows], bias[kMaxRows], wrench[kMaxRows * kMaxMarkers * 6];
  int32_t on_velocity[kMaxRows] = {};
  // What it forgets is seen.
  for (double* values : {residual, rate, bias}) std::fill_n(values, table_.row_count, kNotANumber);
  std::fill_n(wrench, 6 * n * table_.row_count, kNotANumber);
  ErrorText why;
  lithe_rows out{};
  out.struct_size = sizeof out;
  out.marker_count = n, out.row_count = table_.row_count;
  out.residual = residual, out.rate = rate, out.bias = bias, out.wrench = wrench;
  out.on_velocity = on_velocity, out.quarter_turns = rows.quarter_turns();
  if (rows.stiffness()) out.multipliers = rows.multipliers(), out.stiffness = rows.stiffness()->data();
  out.error = why.text, out.error_size = sizeof why.text;
  const int32_t code = table_.evaluate(object_.get(), time, markers.all, &out);
  if (code < 0) object_.fail(*this, why);
  for (int r = 0; r < table_.row_count; ++r) {
    Wrench* W = on_velocity[r] ? rows.open_velocity() : rows.open();
    if (code > 0) {
      rows.finish(kNotANumber, kNotANumber, kNotANumber);
      continue;
    }
    for (int m = 0; m < n; ++m) W[m] = wrench_at(wrench + 6 * (n * r + m));
    if (out.no_stiffness)
      rows.finish_written(residual[r], bias[r], rate[r]);
    else
      rows.finish(residual[r], bias[r], rate[r]);
  }
}

ForceFromC::ForceFromC(Parameters parameters)
    : table_(parameters.type->table),
      object_(*parameters.type, parameters.values),
      angles_(angles_of(table_, object_)) {}

void ForceFromC::initialize(std::span<const MarkerView> markers) { initialize_with(table_, object_, markers); }

void ForceFromC::evaluate(double time, std::span<const MarkerView> views, ForceRows& rows) const {
  const Markers markers(views);
  const int n = table_.marker_count;
  double tension[kMaxRows], stiffness[kMaxRows], damping[kMaxRows], wrench[kMaxRows * kMaxMarkers * 6];
  double load[kMaxMarkers * 6] = {};
  for (double* values : {tension, stiffness, damping}) std::fill_n(values, table_.row_count, kNotANumber);
  std::fill_n(wrench, 6 * n * table_.row_count, kNotANumber);
  ErrorText why;
  lithe_force_rows out{};
  out.struct_size = sizeof out;
  out.marker_count = n, out.row_count = table_.row_count;
  out.load = load, out.wrench = wrench;
  out.tension = tension, out.stiffness = stiffness, out.damping = damping;
  out.quarter_turns = rows.quarter_turns();
  out.error = why.text, out.error_size = sizeof why.text;
  const int32_t code = table_.evaluate(object_.get(), time, markers.all, &out);
  if (code < 0) object_.fail(*this, why);
  for (const MarkerView& view : views)
    rows.add_load(view, code > 0 ? force(Vector3::Constant(kNotANumber)) : wrench_at(load + 6 * view.index));
  for (int r = 0; r < table_.row_count; ++r) {
    Wrench* W = rows.open();
    for (int m = 0; m < n; ++m)
      W[m] = code > 0 ? Wrench{Vector3::Zero(), Vector3::Zero()} : wrench_at(wrench + 6 * (n * r + m));
    if (code > 0)
      rows.finish(kNotANumber, kNotANumber, kNotANumber);
    else
      rows.finish(tension[r], stiffness[r], damping[r]);
  }
  rows.add_energy(code > 0 ? kNotANumber : out.energy);
}

template std::unique_ptr<ConstraintBatch> make_constraint_batch<JointFromC>();
template std::unique_ptr<ForceBatch> make_force_batch<ForceFromC>();

}  // namespace lithe
