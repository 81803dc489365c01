#pragma once

#include <limits>
#include <memory>
#include <string>
#include <string_view>

#include "engine/model/state.h"
#include "engine/motion/equations_of_motion.h"

namespace lithe {

class Archive;
class SingularPose;

/// The one tolerance convention: a component x of the chart increment or of v may err by absolute + relative |x| a step
/// (rotations: |x| = 1 rad); the root mean square of error over allowance is kept below 1.
struct Tolerance {
  double relative = 1e-6;
  double absolute = 1e-8;
};

/// What an integrator has done since start().
struct IntegratorStatistics {
  long steps = 0, rejected = 0, newton_iterations = 0, factorizations = 0, evaluations = 0;
  long newton_failures = 0;  // steps repeated because Newton did not converge, part of `rejected`
  int limiting = -1;         // index of the velocity with the largest share in the last error estimate; -1: none made

  /// Counts add up; `limiting` is the later one's.
  IntegratorStatistics& operator+=(const IntegratorStatistics& later);
  /// Into or out of an archive, under that name.
  void keep(Archive& archive, std::string_view name);
};

/// How a step ended. On failure the state holds the last good time and `why` says what stopped it; else it is empty, or
/// what the log is to say of the step.
struct StepResult {
  enum class Outcome { reached, failed } outcome = Outcome::reached;
  std::string why;
  bool ok() const { return outcome == Outcome::reached; }
};

/// Whether a step must find the multipliers at its end, or may leave State::lambda empty where they are not part of the
/// method and cost extra: Snapshot::multipliers() then finds them.
enum class Multipliers { found, later };

/// Advances a state of the equations of motion. Keeps its own history; a changed state needs start().
class Integrator {
 public:
  Integrator();
  virtual ~Integrator();
  virtual std::string name() const = 0;
  /// Forgets the past and makes state.v_dot, state.lambda consistent with (time, q, v).
  void start(EquationsOfMotion& equations, State& state);
  /// One step, never past t_stop; t_stop is hit exactly. Trouble inside (no convergence) is met with smaller steps
  /// first, as is an angle that is lost within the step, by methods that choose their steps. Where the angles of joints
  /// would pass half a turn in it, by their motion in the last two steps, the step is cut, so that turns are counted.
  /// Where closed loops lose rank on the way and steps shrink towards that pose, steps along one polynomial lead
  /// through it on the branch that the velocity tells (SingularPose), the first of them is logged, and the method
  /// begins anew behind it.
  StepResult step(EquationsOfMotion& equations, State& state, double t_stop,
                  Multipliers multipliers = Multipliers::found);
  virtual const IntegratorStatistics& statistics() const = 0;
  /// Whether it moves scenes with contacts of rigid surfaces; start() refuses them otherwise.
  virtual bool handles_rigid_contacts() const { return false; }
  /// Whether the v_dot and lambda that the last step left are the method's approximations (BDF: the slope of a
  /// polynomial, and multipliers that no error test sees; what Newton left, over h²), less exact than its q and v.
  /// Observers are then given those of the equations at (t, q, v) (Snapshot); the state, and with it the run, keeps the
  /// method's.
  virtual bool approximates_accelerations() const { return false; }

  /// Dense output: the motion within the last step, which led from `from` to `to`, at from.time <= time <= to.time.
  /// Fills time, q, v, v_dot, lambda; quarter_turns are those of `from`. The common one is the polynomial of degree 5
  /// through q, v, v_dot of both ends in the chart of `from` (error O(h⁶) in q), lambda linear; methods of higher order
  /// bring their own. Constraints hold to its error: project where they must hold exactly.
  virtual void interpolate(const Layout& layout, const State& from, const State& to, double time, State& out) const;

  /// All that the next steps from `state` depend on besides the state: saved, or loaded into an integrator with the
  /// same parameters that has been started with these equations and a copy of the state (SceneError for other
  /// parameters, FileError for an archive of something else). False: the method cannot tell its history; a run then
  /// starts it anew wherever it is saved, and so does the resumed one: both continue with the same bits.
  bool history(Archive& archive, EquationsOfMotion& equations, const State& state);

  /// Whether the motion is that of the equations at (t, q, v), which then tell v_dot and lambda at any time; false
  /// where a part of the scene is held back, or pressed by impulses. Events watch what the equations tell: dense output
  /// has lambda by interpolation alone.
  virtual bool follows_equations() const { return true; }

 protected:
  /// The method's own start and step; angles are counted around them.
  virtual void prepare(EquationsOfMotion& equations, State& state) = 0;
  virtual StepResult advance(EquationsOfMotion& equations, State& state, double t_stop) = 0;
  /// What is asked of the present step.
  Multipliers multipliers() const { return multipliers_; }
  /// The method's own part of history(): archive.same() its parameters, then archive() each member that outlives a
  /// step, its statistics among them.
  virtual bool keep(Archive& /*archive*/, EquationsOfMotion& /*equations*/, const State& /*state*/) { return false; }
  /// Whether it chooses its steps by a tolerance.
  virtual bool chooses_steps() const { return false; }
  /// The factor that the equations hold has been replaced between steps.
  virtual void lose_factor() {}
  /// Steps are another integrator's, which meets singular poses itself.
  virtual bool delegates() const { return false; }
  /// Whether prepare() begins anew behind a singular pose: statistics go on.
  bool resumes() const { return resumes_; }

 private:
  void track(EquationsOfMotion& equations, State& state) const;
  void limit_turn(const VectorX& quarter_turns, double length);
  StepResult see_angles(EquationsOfMotion& equations, State& state);
  std::string pass_singular_pose(EquationsOfMotion& equations, State& state, double t_stop);
  bool has_shrunk(double length, bool cut);

  Multipliers multipliers_ = Multipliers::found;
  VectorX quarter_turns_, turn_rates_;  // before the step; over the last one, quarter_turns a second
  double last_length_ = 0;              // s
  double longest_ = std::numeric_limits<double>::infinity();  // next step, s
  State before_;                                              // of see_angles()
  // Steps that shrink may lead to a singular pose.
  double usual_ = 0, looked_at_ = 0;  // s: the longest of late; where a look has found none (0: not looked)
  bool resumes_ = false;
  std::unique_ptr<SingularPose> singular_pose_;  // once looked for
};

/// A step for messages: "2.4e-07 s".
std::string step_text(double h);

/// Root mean square of error over allowance (Tolerance), for an error in the chart or in v with component magnitudes
/// |x|.
double error_ratio(ConstVectorRef error, ConstVectorRef magnitudes, const Tolerance& tolerance);

/// Index of the component with the largest share in that ratio; -1 for none.
int largest_share(ConstVectorRef error, ConstVectorRef magnitudes, const Tolerance& tolerance);

}  // namespace lithe
