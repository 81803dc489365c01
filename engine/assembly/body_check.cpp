#include "engine/assembly/body_check.h"

#include <algorithm>
#include <string>

#include "engine/base/error.h"

namespace lithe {
namespace {

void check_frames(const Body& body) {
  const Coordinates c = body.coordinates();
  const auto wrong = [&](const FramePair& p) { return p.first < 0 || p.first >= p.second || p.second >= c.frames; };
  std::string problem;
  if (std::any_of(c.pairs.begin(), c.pairs.end(), wrong))
    problem = "couples frames that it does not have, or a frame with itself";
  if (!problem.empty())
    throw SceneError("body '" + body.name() + "' " + problem, body.where(),
                     "its author is to fix coordinates(): pairs (first, second) with 0 <= first < second < frames");
}

}  // namespace

void read_initial_state(const Body& body, VectorRef q, VectorRef v) {
  check_frames(body);
  body.initial_state(q, v);
  if (!q.allFinite() || !v.allFinite())
    throw SceneError("body '" + body.name() + "' starts with a coordinate that is not finite", body.where(),
                     "give finite initial position, orientation and velocities");
}

}  // namespace lithe
