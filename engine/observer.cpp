#include "engine/observer.h"

#include <cmath>

#include "engine/error.h"
#include "engine/output/number_text.h"

namespace lithe {

Schedule every(double interval) {
  if (!(interval > 0) || !std::isfinite(interval))
    throw SceneError("observers cannot be told every " + std::to_string(interval) + " s", "every",
                     "give an interval above zero, or every_step()");
  return {interval};
}

std::string time_text(double time) {
  std::string text = "t = ";
  append_number(text, time);
  return text + " s";
}

}  // namespace lithe
