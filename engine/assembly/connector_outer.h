#pragma once

#include <span>

#include "engine/assembly/batch.h"

namespace lithe::connector {

/// Adds Jᵢᵀ w (J_jᵀ by)ᵀ of two markers of one connector, given their slots, to frames and their couplings.
void add_outer(Workspace& work, const BlockStructure& blocks, std::span<const MarkerSlot> on, const Wrench& w,
               std::span<const MarkerSlot> from, const Wrench& by);

}  // namespace lithe::connector
