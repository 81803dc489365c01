#include "engine/observe/event.h"

#include <utility>

namespace lithe {

EventFunction watch(Sensor sensor, int column) {
  return [sensor = std::move(sensor), column](Snapshot& now) { return sensor.value(now, column); };
}

}  // namespace lithe
