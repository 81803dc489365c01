#include "engine/gradient/sensor_derivative.h"

#include <cmath>

#include "engine/base/error.h"
#include "engine/gradient/differences.h"
#include "engine/run/kinks.h"

namespace lithe {

namespace {
constexpr double kProbe = 1e-3;  // m, rad, to see on what a sensor depends
}  // namespace

SensorDerivative::SensorDerivative(const Drawing& drawing, Drawing::Place place, const std::vector<State>& probes)
    : drawing_(drawing), place_(place), snapshot_(drawing.system()), bends_(!find_kinks(drawing.system()).empty()) {
  const Layout& layout = drawing.system().layout();
  for (const Layout::BodySlice& b : layout.bodies()) {
    const int count = (b.frame ? 6 : 0) + b.linear;
    for (const bool velocity : {false, true}) {
      bool depends = false;
      for (std::size_t i = 0; i < probes.size() && !depends; ++i) {
        State state = probes[i];
        const double before = value(state);
        VectorX by = VectorX::Zero(layout.v_count());
        for (int k = 0; k < count; ++k) by[b.v + k] = kProbe * (1 + 0.37 * k - 0.11 * k * k);
        if (velocity)
          state.v += by * (1 + largest_entry(state.v));
        else
          layout.retract(state.q, by, state.q);
        try {
          depends = value(state) != before;
        } catch (const SimulationError&) {  // not defined so far away
          depends = true;
        }
      }
      if (depends) parts_.push_back({b.v, count, velocity});
    }
  }
}

double SensorDerivative::value(const State& state) {
  snapshot_.evaluate(state, Accelerations::solved);
  const double value = drawing_.sensor(place_.sensor).value(snapshot_, place_.column);
  if (std::isfinite(value)) return value;
  throw SimulationError("the sensor '" + drawing_.sensor(place_.sensor).name() + "' gives a value that is not finite",
                        "t = " + std::to_string(state.time) + " s", "look at what it reads there");
}

void SensorDerivative::add(const State& state, double weight, Eigen::Ref<VectorX> turn, Eigen::Ref<VectorX> velocity) {
  const Layout& layout = drawing_.system().layout();
  State near = state;
  VectorX by = VectorX::Zero(layout.v_count());
  /// Calls take(entry, part, step, value by what is added to the entry) for all that it depends on.
  const auto visit = [&](const auto& take) {
    for (const Part& part : parts_) {
      const double h = part.velocity ? kDirectionStep * (1 + largest_entry(state.v)) : kDirectionStep;
      for (int i = part.first; i < part.first + part.count; ++i) {
        take(i, part, h, [&](double t) -> VectorX {
          if (part.velocity) {
            near.v[i] = state.v[i] + t;
          } else {
            by[i] = t;
            layout.retract(state.q, by, near.q);
          }
          return VectorX::Constant(1, value(near));
        });
        by[i] = 0;
        near.v[i] = state.v[i];
      }
      near.q = state.q;
    }
  };
  if (scales_[0] == 0 && scales_[1] == 0)
    visit([&](int /*entry*/, const Part& part, double h, const auto& at) {
      difference(h, bends_, scales_[part.velocity], at);
    });
  visit([&](int entry, const Part& part, double h, const auto& at) {
    (part.velocity ? velocity : turn)[entry] += weight * difference(h, bends_, scales_[part.velocity], at)[0];
  });
}

}  // namespace lithe
