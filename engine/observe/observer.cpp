#include "engine/observe/observer.h"

#include <cmath>

#include "engine/base/error.h"

namespace lithe {

Schedule every(double interval) {
  if (!(interval > 0) || !std::isfinite(interval))
    throw SceneError("observers cannot be called every " + std::to_string(interval) + " s", "every",
                     "give an interval above zero, or every_step()");
  return {interval};
}

}  // namespace lithe
