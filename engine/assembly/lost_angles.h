#pragma once

#include <span>
#include <vector>

#include "engine/model/marker.h"
#include "engine/model/state.h"

namespace lithe {

class Connector;
struct MeasuredAngle;
class Evaluator;

/// Angles that are lost within a step: what they look at passes so near to the axis that they turn about that they jump
/// by about half a turn. A force, drive, coupling or friction that reads such an angle takes the jump for a motion.
/// What a joint offers and none of them reads may jump: sensors tell what is there.
class LostAngles {
 public:
  explicit LostAngles(Evaluator& evaluator);
  /// Whether check() would throw.
  bool loses(const State& state);
  /// After a step: throws SimulationError that names who reads the angle. Steps that follow each other alone are looked
  /// at; the state is evaluated where an angle has turned by more than a quarter.
  void check(const State& state);

 private:
  struct Reader {
    const Connector* connector;
    std::vector<Marker> markers;
    int first, place;  // State::quarter_turns: of the connector's first angle; among its own
  };
  void find_readers(const State& state);
  struct Lost {
    const Reader* reader;  // null: none
    double nearest;        // to the axis, rad
  };
  Lost find(const State& state);
  double nearest_way(const Reader& reader, const State& state);

  Evaluator& evaluator_;
  std::vector<Reader> readers_;
  bool found_ = false;    // readers_
  State last_;            // the state looked at last: q, quarter_turns
  bool follows_ = false;  // there is one
};

extern const char* const kLostAngleFix;

/// What an angle looks at, as a unit vector in axes of its marker A, the third of which the angle turns about.
Vector3 arm_of(const MeasuredAngle& angle, std::span<const MarkerView> markers);
/// How far such a vector stands off the third axis, rad.
double off_axis(const Vector3& arm);

}  // namespace lithe
