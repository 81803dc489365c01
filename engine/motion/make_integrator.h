#pragma once

#include <functional>
#include <memory>

#include "engine/motion/integrator.h"

namespace lithe {

/// Makes integrators that are alike, one a call: an island, a run.
using MakeIntegrator = std::function<std::unique_ptr<Integrator>()>;

/// Likewise, for what its caller leaves open: a Tolerance, a step in s, the system that it is to move.
template <class Setting>
using MakeIntegratorBy = std::function<std::unique_ptr<Integrator>(Setting)>;

}  // namespace lithe
