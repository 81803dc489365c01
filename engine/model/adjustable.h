#pragma once

#include "engine/base/checks.h"
#include "engine/model/input.h"

namespace lithe {

/// A number of an element: constant, or an Input's while a run goes on.
///   graph.add<SpringDamper>("strut", {A, B}, {.stiffness = 3e4, .damping = damping});  // `damping` is an Input
class Adjustable {
 public:
  Adjustable(double value) : value_(value) {}                    // NOLINT: implicit on purpose
  Adjustable(const Input& input) : value_(0), input_(&input) {}  // NOLINT: implicit on purpose
  Adjustable(const Input&& input) = delete;

  double at(double time) const { return input_ ? input_->value(time) : value_; }
  /// Whether it may change within a run.
  bool varies() const { return input_ != nullptr; }
  /// Null: a number.
  const Input* input() const { return input_; }
  /// Calls check(value, parameter) (engine/base/checks.h) of the number, or of both bounds of the input where they are
  /// finite and of its value as drawn.
  template <class Check>
  void require(Check&& check, const std::string& parameter) const {
    if (!input_) return check(value_, parameter);
    const auto& p = input_->parameters();
    const std::string which = parameter + " (input '" + input_->name() + "')";
    check(p.value, which);
    for (const double bound : {p.lower, p.upper})
      if (std::isfinite(bound)) check(bound, which + " at its bound");
  }
  /// Of all three: finite.
  void require_finite(const std::string& parameter) const {
    require([](double value, const std::string& name) { lithe::require::finite(value, name); }, parameter);
  }

 private:
  double value_;
  const Input* input_ = nullptr;
};

namespace require {

/// Where a motion is prescribed: throws SceneError for an Input that jumps between samples.
void without_jumps(const MotionLaw& law, const std::string& parameter);

}  // namespace require
}  // namespace lithe
