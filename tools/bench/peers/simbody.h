#pragma once

#include <Simbody.h>

#include <functional>
#include <memory>

#include "tools/bench/peers/peer.h"

/// What Simbody's two files share.
namespace lithe::bench::peers {

inline Point point(const SimTK::Vec3& v) { return {v[0], v[1], v[2]}; }

/// A model in Simbody's terms: generalised coordinates of a tree, closures, forces.
struct SimbodyModel {
  SimTK::MultibodySystem system;
  SimTK::SimbodyMatterSubsystem matter{system};
  SimTK::GeneralForceSubsystem forces{system};

  SimbodyModel() { matter.setShowDefaultGeometry(false); }
};

/// Of mass and inertia about its centre `com`; its frame is elsewhere.
SimTK::Body::Rigid simbody_body(double mass, const SimTK::Vec3& com, const SimTK::Vec3& central_moments);

/// Integrates to request.end and leaves cost and steps in `outcome`; `watch(state)`, if any, is called after every
/// step. Every step is projected onto the loops if `project`; Simbody itself does so only where the drift asks for it.
SimTK::State simbody_integrate(const Request& request, SimbodyModel& model, const SimTK::State& start, bool project,
                               Outcome& outcome, const std::function<void(const SimTK::State&)>& watch = {});

Outcome run_simbody_andrews(const Request& request);
Outcome run_simbody_four_bar(const Request& request);
Outcome run_simbody_bricard(const Request& request);

}  // namespace lithe::bench::peers
