#pragma once

#include "engine/study/study.h"

/// Scenes of examples/studies/ that are measured here too.
namespace lithe::bench {

namespace andrews_squeezer {
StudyScene scene();
}
namespace flyball_governor {
StudyScene scene();
}

}  // namespace lithe::bench
