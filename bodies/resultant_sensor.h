#pragma once

#include "engine/observe/sensors.h"

namespace lithe {

/// A sensor of a force and a moment in section axes: columns n_1 … n_3 (N), m_1 … m_3 (N m).
Sensor resultant_sensor(Located name, std::function<Vector6(Snapshot&)> reading);

}  // namespace lithe
