#pragma once

#include <cvode/cvode.h>
#include <gtest/gtest.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

#include <cmath>
#include <span>
#include <string>
#include <vector>

#include "engine/fmu/fmu_instance.h"
#include "integrators/sundials_internal.h"
#include "lithe/lithe.h"

/// Importers that integrate an FMU for model exchange themselves.
namespace lithe::test {

using Values = std::vector<double>;

/// An importer: the classical method of Runge and Kutta at fixed steps; events by halving, from a step's start.
template <class One>
class Importer {
 public:
  Importer(One& one, int states, int indicators, double time = 0)
      : one_(one), time_(time), x_(static_cast<std::size_t>(states)), z_(static_cast<std::size_t>(indicators)) {
    handle_event();
  }

  /// In event mode already, or just there.
  void handle_event() {
    bool changed = false;
    ok(one_.update(changed));
    ok(one_.call("EnterContinuousTimeMode"));
    ok(one_.states(x_));
    ok(one_.indicators(z_));
  }
  void step(double h) {
    const Values from = x_;
    const double begin = time_;
    move(from, begin, h);
    bool event = false;
    if (crosses()) {
      double before = 0, behind = h;
      while (behind - before > 1e-14) {
        move(from, begin, (before + behind) / 2);
        (crosses() ? behind : before) = (before + behind) / 2;
      }
      move(from, begin, behind);
      event = true;
      ++crossings;
    }
    bool asks = false;
    ok(one_.complete_step(asks));
    corrections += asks;
    if (event || asks) {
      ok(one_.call("EnterEventMode"));
      handle_event();
    }
    if (time_ < begin + h) step(begin + h - time_);
  }
  void run(double end, double h) {
    const long steps = std::lround((end - time_) / h);
    const double begin = time_;
    for (long i = 1; i <= steps; ++i) step(begin + static_cast<double>(i) * h - time_);
  }
  double time() const { return time_; }
  const Values& states() const { return x_; }
  const Values& indicators() const { return z_; }
  void go_on_from(double time) {
    time_ = time;
    ok(one_.states(x_));
  }
  long crossings = 0, corrections = 0;

 private:
  static void ok(int status) { ASSERT_EQ(status, 0); }
  void move(const Values& from, double begin, double h) {
    Values k(from.size()), sum(from.size()), x = from;
    constexpr double kTime[] = {0, 0.5, 0.5, 1}, kWeight[] = {1.0 / 6, 1.0 / 3, 1.0 / 3, 1.0 / 6};
    for (int i = 0; i < 4; ++i) {
      for (std::size_t j = 0; j < x.size(); ++j) x[j] = from[j] + kTime[i] * h * k[j];
      ok(one_.set_time(begin + kTime[i] * h));
      ok(one_.set_states(x));
      ok(one_.derivatives(k));
      for (std::size_t j = 0; j < x.size(); ++j) sum[j] += kWeight[i] * h * k[j];
    }
    for (std::size_t j = 0; j < x.size(); ++j) x_[j] = from[j] + sum[j];
    time_ = begin + h;
    ok(one_.set_time(time_));
    ok(one_.set_states(x_));
  }
  bool crosses() {
    Values now(z_.size());
    ok(one_.indicators(now));
    for (std::size_t i = 0; i < now.size(); ++i)
      if ((now[i] > 0) != (z_[i] > 0)) return true;
    return false;
  }

  One& one_;
  double time_;
  Values x_, z_;
};

/// An importer with the Adams methods of CVODE at a tolerance, which starts anew at events.
class CvodeImporter : SundialsMemory<CvodeImporter> {
 public:
  CvodeImporter(FmuInstance& instance, double tolerance) : instance_(instance) {
    y_ = N_VNew_Serial(instance.states().size(), context);
    map(y_) = instance.states();
    cvode_ = CVodeCreate(CV_ADAMS, context);
    solver_ = SUNNonlinSol_FixedPoint(y_, 0, context);
    ok(CVodeInit(cvode_, rate, instance.time(), y_));
    ok(CVodeSetUserData(cvode_, this));
    ok(CVodeSStolerances(cvode_, tolerance, tolerance));
    ok(CVodeSetNonlinearSolver(cvode_, solver_));
    ok(CVodeRootInit(cvode_, instance.equations().indicator_count(), root));
    ok(CVodeSetNoInactiveRootWarn(cvode_));
  }
  ~CvodeImporter() {
    CVodeFree(&cvode_);
    SUNNonlinSolFree(solver_);
    N_VDestroy(y_);
  }
  /// `stepped` sees the states after each step and its events.
  template <class Look>
  void run(double end, Look&& stepped) {
    while (instance_.time() < end) {
      double time = 0;
      ok(CVodeSetStopTime(cvode_, end));
      const int flag = CVode(cvode_, end, y_, &time, CV_ONE_STEP);
      ASSERT_GE(flag, 0) << thrown;
      set(time, y_);
      const bool drifted = instance_.complete_step(), event = flag == CV_ROOT_RETURN;
      ++steps, corrections += drifted, crossings += event;
      if (drifted || event) {
        instance_.update();
        map(y_) = instance_.states();
        ok(CVodeReInit(cvode_, time, y_));
      }
      stepped(instance_.states());
    }
  }
  long steps = 0, corrections = 0, crossings = 0;

 private:
  static void ok(int flag) { ASSERT_EQ(flag, CV_SUCCESS); }
  void set(double time, N_Vector y) {
    instance_.set_time(time);
    instance_.set_states({N_VGetArrayPointer(y), static_cast<std::size_t>(N_VGetLength(y))});
  }
  static int rate(double time, N_Vector y, N_Vector y_dot, void* user) {
    return guarded(user, [&](CvodeImporter& self) {
      self.set(time, y);
      map(y_dot) = self.instance_.derivatives();
      return true;
    });
  }
  static int root(double time, N_Vector y, double* values, void* user) {
    return guarded(user, [&](CvodeImporter& self) {
      self.set(time, y);
      self.instance_.indicators({values, static_cast<std::size_t>(self.instance_.equations().indicator_count())});
      return true;
    });
  }
  friend SundialsMemory;

  FmuInstance& instance_;
  N_Vector y_;
  void* cvode_;
  SUNNonlinearSolver solver_;
};

}  // namespace lithe::test
