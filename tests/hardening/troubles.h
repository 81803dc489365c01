#pragma once

#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <stdexcept>

#include "bodies/rigid_body.h"
#include "engine/assembly/batch_of.h"
#include "engine/observe/observer.h"
#include "engine/run/simulation.h"

/// Elements of a user that go wrong at some time, and a pendulum that they are part of.
namespace lithe::test {

enum class Trouble { none, not_a_number, throws, throws_no_exception };

struct When {
  Trouble trouble = Trouble::none;
  double time = 0.305;  // s, from here on

  /// 0; NaN, or a throw, from the time on.
  double check(double now) const {
    if (now <= time) return 0;
    if (trouble == Trouble::throws) throw std::out_of_range("no such entry in the table");
    if (trouble == Trouble::throws_no_exception) throw 42;
    return trouble == Trouble::not_a_number ? std::numeric_limits<double>::quiet_NaN() : 0;
  }
};

class TroubledForce final : public Force<1, 0> {
 public:
  using Parameters = When;
  explicit TroubledForce(When when) : when_(when) {}
  void evaluate(double time, std::span<const MarkerView> m, ForceRows& rows) const override {
    rows.add_load(m[0], force(Vector3(1, 0, when_.check(time))));
  }

 private:
  const When when_;
};

class TroubledBall final : public Joint<2, 3> {
 public:
  using Parameters = When;
  explicit TroubledBall(When when) : when_(when) {}
  void evaluate(double time, std::span<const MarkerView> m, ConstraintRows& rows) const override {
    coincident(m[0], m[1], rows);
    rows.drive_last(when_.check(time), 0, 0);
  }

 private:
  const When when_;
};

/// A mass on a rail, its one coordinate the time it has: it moves at 1 m/s, drawn by nothing.
class TroubledSlider final : public Body {
 public:
  using Parameters = When;
  struct Cache : BodyCache {
    explicit Cache(const TroubledSlider&) {}
  };
  explicit TroubledSlider(When when) : when_(when) {}
  Coordinates coordinates() const override { return {.frames = 0, .linear = 1}; }
  std::unique_ptr<BodyCache> make_cache() const override { return std::make_unique<Cache>(*this); }
  void initial_state(VectorRef q, VectorRef v) const override { q.setZero(), v.setOnes(); }
  void evaluate(const BodyState&, Level) const override {}
  void add_residual(const BodyState& s, const double* v_dot, const Vector3&, double* r) const override {
    r[0] += v_dot[0] + when_.check(s.q[0]);
  }
  void add_tangent(const BodyState&, const double*, const Vector3&, const TangentWeights& w,
                   BodyTangent& S) const override {
    S.linear[0] += w.acceleration;
  }
  void marker_kinematics(const BodyState&, int, Level, MarkerKinematics&) const override {}
  BodyEnergy energy(const BodyState&, const Vector3&) const override { return {}; }

 private:
  const When when_;
};

/// Calls what a test wants, at every state.
class Caller final : public Observer {
 public:
  explicit Caller(std::function<void(double time)> call) : call_(std::move(call)) {}
  void observe(Snapshot& snapshot) override { call_(snapshot.time()); }

 private:
  const std::function<void(double time)> call_;
};

}  // namespace lithe::test
