#include "joints/bearings/roller_bearing.h"

#include <algorithm>

#include "engine/assembly/batch_of.h"
#include "engine/base/checks.h"

namespace lithe {

namespace {

/// P at z.
double profile_drop(const RollerBearing::Parameters& p, double z) {
  const double D = p.roller_diameter, L = p.roller_length, end = 2.5 * D;
  if (p.profile_place.empty()) {
    const bool is_long = L > end;
    const double part = is_long ? std::max(0.0, (2 * std::abs(z) - (L - end)) / end) : 2 * z / L;
    return -(is_long ? 5e-4 : 3.5e-4) * D * std::log1p(-part * part);
  }
  const auto& at = p.profile_place;
  const auto next = std::upper_bound(at.begin() + 1, at.end() - 1, z);
  const auto i = static_cast<std::size_t>(next - at.begin());
  const double share = (z - at[i - 1]) / (at[i] - at[i - 1]);
  return (1 - share) * p.profile_drop[i - 1] + share * p.profile_drop[i];
}

void require_profile(const RollerBearing::Parameters& p) {
  const auto& at = p.profile_place;
  if (at.size() != p.profile_drop.size() || at.size() == 1)
    throw SceneError(
        "profile has " + std::to_string(at.size()) + " places and " + std::to_string(p.profile_drop.size()) + " drops",
        "", "give as many of both, at least two, or none of either");
  if (at.empty()) return;
  for (double value : at) require::finite(value, "profile_place");
  for (double value : p.profile_drop) require::not_negative(value, "profile_drop");
  for (std::size_t i = 1; i < at.size(); ++i)
    if (at[i] <= at[i - 1])
      throw SceneError("profile_place does not ascend at entry " + std::to_string(i), "", "sort the table by place");
  if (at.front() > -0.5 * p.roller_length || at.back() < 0.5 * p.roller_length)
    throw SceneError("profile reaches from " + std::to_string(at.front()) + " to " + std::to_string(at.back()) +
                         " m, and not over the roller",
                     "", "give it from -" + std::to_string(0.5 * p.roller_length) + " m to +that, half the length");
}

}  // namespace

RollerBearing::RollerBearing(Parameters p)
    : RollingBearing({p.rollers, p.roller_diameter, p.pitch_diameter, 0, p.roller_length, p.losses}, "rollers") {
  require::positive(p.roller_length, "roller_length");
  require::finite(p.clearance, "clearance");
  if (p.slices < 1) throw SceneError("slices is " + std::to_string(p.slices), "", "give 30 or more");
  require_profile(p);
  stiffness_ = 35948e6 * std::pow(p.roller_length, 8.0 / 9) / p.slices;
  for (int k = 0; k < p.slices; ++k) {
    place_.push_back(((k + 0.5) / p.slices - 0.5) * p.roller_length);
    free_.push_back(0.5 * p.clearance + 2 * profile_drop(p, place_.back()));
  }
}

RollingBearing::PlaneLoad RollerBearing::in_plane(const Vector3& motion) const {
  PlaneLoad load;
  for (std::size_t k = 0; k < place_.size(); ++k) {
    const double z = place_[k], depth = motion[1] + z * motion[2] - free_[k];
    if (depth <= 0) continue;
    const double secant = stiffness_ * std::pow(depth, 1.0 / 9), Q = secant * depth, tangent = 10.0 / 9 * secant;
    load.energy += 9.0 / 19 * Q * depth;
    load.force += Q * Vector3(0, 1, z);
    load.stiffness += tangent * Vector3(0, 1, z) * Vector3(0, 1, z).transpose();
  }
  load.element.force = load.force[1];
  return load;
}

template std::unique_ptr<ForceBatch> make_force_batch<RollerBearing>();

}  // namespace lithe
