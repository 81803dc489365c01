#pragma once

#include <functional>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "engine/assembly/system.h"
#include "engine/motion/integrator.h"
#include "joints/contact/contact.h"

/// Motions with contact whose end is known to many digits, for work-precision charts.
namespace lithe::contact_bench {

struct KnownMotion {
  std::string name, title;
  double end;  // s
  /// One body, "body", and one Contact under the given law; its restitution is the scene's own.
  std::function<void(SystemGraph& graph, const std::variant<Compliance, RigidSurfaces, Sensing>& law)> draw;
  double restitution;
  /// How far the state is from the answer at the end, m.
  std::function<double(const State& state)> error;
};

/// A ball thrown without spin slides, then rolls; a ball that bounces until 3 s, five times; a block that rocks on its
/// corners (Housner 1963), as long as it would take for five impacts.
std::vector<KnownMotion> known_motions();

}  // namespace lithe::contact_bench
