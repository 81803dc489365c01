#include "bodies/resultant_sensor.h"

namespace lithe {

Sensor resultant_sensor(Located name, std::function<Vector6(Snapshot&)> reading) {
  std::vector<std::string> columns;
  for (const char* ending : {"_n_1", "_n_2", "_n_3", "_m_1", "_m_2", "_m_3"}) columns.push_back(name.text + ending);
  return {std::move(name),
          std::move(columns),
          [reading = std::move(reading)](Snapshot& now, std::span<double> values) {
            Eigen::Map<Vector6>(values.data()) = reading(now);
          },
          {"N", "N", "N", "N m", "N m", "N m"}};
}

}  // namespace lithe
