#pragma once

#include <memory>
#include <optional>

#include "engine/forward/rigid_scene.h"

namespace lithe {

class System;

/// None if the scene holds anything but rigid bodies and lower pairs, or friction that asks for reactions.
std::optional<RigidScene> find_rigid_scene(const System& system);

/// The kernel for a scene, null if none serves: planar mechanisms first, then trees.
std::unique_ptr<ForwardKernel> make_forward_kernel(const RigidScene& scene);

/// That of the kernel which serves a system.
ForwardMethod find_forward_method(const System& system);

}  // namespace lithe
