#pragma once

#include <memory>
#include <string>
#include <vector>

#include "engine/model/marker.h"
#include "engine/model/state.h"

namespace lithe {

class Constraint;
class Evaluator;
class LimitedMotion;
class LostAngles;

/// What no method sees of a state: rows that are left out since they repeat others, which hold only as long as they
/// agree with those, joints within their limits, and angles that are read and were lost on the way.
class ReachedState {
 public:
  /// Null where the scene has none of these.
  static std::unique_ptr<ReachedState> make(Evaluator& evaluator);
  ~ReachedState();

  /// Whether check() would throw for an angle that the step has lost.
  bool loses_angle(const State& state);
  /// A row that is left out may be off by 1e-6, in its units (m, rad; rows on velocities: of 1 and the fastest
  /// velocity), and by a thousand times what the others are off by. Looked at where the step evaluated last, beside the
  /// state; at the state itself only where something is off there. Not after a step by forward dynamics.
  void check(const State& state);
  /// Of the start, with its accelerations: whether the rates and accelerations of those rows agree with the others'.
  /// Throws SceneError.
  void check_start(const State& start);

 private:
  struct Limited {
    const Constraint* joint;
    const LimitedMotion* limits;
    std::vector<Marker> markers;
  };
  explicit ReachedState(Evaluator& evaluator);
  /// Of the state evaluated last; "" if it is within its limit.
  std::string beyond_limit(const Limited& limited);
  /// The row that is off at the state evaluated last, its value in rows_; -1: none.
  int find_row();

  Evaluator& evaluator_;
  std::vector<Limited> limited_;
  std::unique_ptr<LostAngles> angles_;  // null: none are measured
  long evaluations_ = 0;                // that are looked at
  VectorX rows_, rates_;
  std::vector<MarkerKinematics> markers_;
};

/// "'a' and 'b' repeat each other but do not agree: 'b' row 1, which is left out,": kContradict, and the elements whose
/// rows that one repeats at the state evaluated last.
std::string contradiction(Evaluator& evaluator, int row);
constexpr const char* kContradict = "repeat each other but do not agree";
extern const char* const kContradictionFix;

}  // namespace lithe
