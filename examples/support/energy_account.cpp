#include "examples/support/energy_account.h"

#include <algorithm>
#include <cmath>

namespace machine {

using namespace lithe;

namespace {

/// W that the damping of a beam takes: σ_d · ε̇ along its elements, of uncoupled sections.
double damping_power(const Beam& beam, const BodyState& state) {
  double sum = 0;
  for (int i = 0; i < beam.element_count(); ++i) {
    const BeamSpan& span = beam.element(i);
    const BeamSection& section = span.section();
    const Vector6 viscous = beam.resultants(state, i) - section.stiffness * beam.strain(state, i);
    for (int k = 0; k < 6; ++k)
      if (section.damping[k] > 0)
        sum += span.length() * viscous[k] * viscous[k] / (section.stiffness(k, k) * section.damping[k]);
  }
  return sum;
}

double damping_power(const FlexibleBody& body, const BodyState& state) {
  const VectorX force = body.damping_force(state);
  return -force.dot(Eigen::Map<const VectorX>(state.v, force.size()));
}

double damping_power(const Body& body, Snapshot& now) {
  BodyState state = now.body_state(body);
  if (const auto* beam = dynamic_cast<const Beam*>(&body)) return damping_power(*beam, state);
  if (const auto* flexible = dynamic_cast<const FlexibleBody*>(&body)) return damping_power(*flexible, state);
  const auto* slender = dynamic_cast<const SlenderBody*>(&body);
  if (!slender) return 0;
  state.cache = static_cast<SlenderBody::Cache*>(state.cache)->inner.get();
  return slender->beam() ? damping_power(*slender->beam(), state) : damping_power(*slender->flexible(), state);
}

}  // namespace

EnergyAccount::EnergyAccount(const SystemGraph& graph, std::vector<Sensor> more)
    : graph_(graph), more_(std::move(more)) {}

double EnergyAccount::power(Snapshot& now) const {
  double sum = 0;
  for (const SystemGraph::ForceEntry& entry : graph_.forces())
    for (int m = 0; m < static_cast<int>(entry.markers.size()); ++m) {
      // States of controllers and of oil are coordinates without energy.
      const auto* states = dynamic_cast<const PlacelessBody*>(entry.markers[m].body);
      if (states && !states->has_energy()) continue;
      Vector6 wrench;
      applied_force(*entry.force, m).evaluate(now, {wrench.data(), 6});
      const MarkerKinematics k = now.marker(entry.markers[m]);
      sum += wrench.head<3>().dot(k.v) + wrench.tail<3>().dot(k.w);
    }
  for (const SystemGraph::ConstraintEntry& entry : graph_.constraints())
    if (dynamic_cast<const CoordinateDrive*>(entry.constraint)) sum += lithe::power(*entry.constraint).value(now);
  for (const Sensor& sensor : more_) sum += sensor.value(now);
  for (const SystemGraph::BodyEntry& entry : graph_.bodies()) sum -= damping_power(*entry.body, now);
  return sum;
}

void EnergyAccount::observe(Snapshot& now) {
  double energy = 0;
  for (const SystemGraph::BodyEntry& entry : graph_.bodies())
    if (!dynamic_cast<const Ground*>(entry.body)) energy += total_energy(*entry.body).value(now);
  if (!times_.empty() && now.time() <= times_.back()) {  // an event: what begins there
    powers_.back() = power(now);
    return;
  }
  times_.push_back(now.time()), energies_.push_back(energy), powers_.push_back(power(now));
}

EnergyAccount::Sum EnergyAccount::sum() const {
  Sum sum{energies_.back() - energies_.front(), 0, 0};
  const std::size_t last = times_.size() - 1;
  const auto secant = [&](std::size_t i) { return (powers_[i] - powers_[i - 1]) / (times_[i] - times_[i - 1]); };
  // Slope at point `at` of the interval that ends at i: of the parabola through its neighbours. Where steps become much
  // shorter a method began anew: there the power may have a kink, which the longer interval must not see.
  const auto slope = [&](std::size_t at, std::size_t i) {
    const std::size_t other = at == i ? i + 1 : i - 1;
    if (other == 0 || other > last) return secant(i);
    const double h = times_[i] - times_[i - 1], beside = times_[other] - times_[other - 1];
    return beside < 0.1 * h ? secant(i) : (beside * secant(i) + h * secant(other)) / (h + beside);
  };
  for (std::size_t i = 1; i <= last; ++i) {
    const double h = times_[i] - times_[i - 1];
    sum.work += 0.5 * h * (powers_[i] + powers_[i - 1]) + h * h / 12 * (slope(i - 1, i) - slope(i, i));
    sum.turned_over += 0.5 * h * (std::abs(powers_[i]) + std::abs(powers_[i - 1]));
    sum.turned_over = std::max(sum.turned_over, std::abs(energies_[i] - energies_.front()));
  }
  return sum;
}

}  // namespace machine
