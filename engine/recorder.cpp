#include "engine/recorder.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "engine/output/binary.h"
#include "engine/output/csv.h"
#include "engine/output/hdf5_table.h"

namespace lithe {
Recorder::Recorder(std::vector<Sensor> sensors, std::source_location where) : sensors_(std::move(sensors)) {
  std::map<std::string, std::string> taken{{"t", "the time"}};
  table_.columns.push_back("t");
  for (const Sensor& sensor : sensors_)
    for (const std::string& column : sensor.columns()) {
      const auto [other, fresh] = taken.try_emplace(column, "the sensor of " + sensor.where());
      if (!fresh)
        throw SceneError("two columns of a recorder are called '" + column + "': " + other->second + " has it too",
                         sensor.where() + ", recorder of " + to_string(where),
                         "name one of the sensors, as in height(marker, \"tip\")");
      table_.columns.push_back(column);
    }
  row_.resize(table_.columns.size());
}

void Recorder::observe(Snapshot& snapshot) {
  std::fill(row_.begin(), row_.end(), std::numeric_limits<double>::quiet_NaN());  // a column forgotten is seen
  row_[0] = snapshot.time();
  std::span<double> rest = std::span(row_).subspan(1);
  for (const Sensor& sensor : sensors_) {
    const auto values = rest.first(sensor.columns().size());
    sensor.evaluate(snapshot, values);
    for (std::size_t i = 0; i < values.size(); ++i)
      if (!std::isfinite(values[i]))
        throw SimulationError("sensor '" + sensor.columns()[i] + "' reads " + std::to_string(values[i]) + " at " +
                                  time_text(snapshot.time()),
                              sensor.where(), "see what it divides by or takes the root of; rows up to then are kept");
    rest = rest.subspan(values.size());
  }
  table_.add_row(row_);
}

void Recorder::write_csv(const std::string& path) const { lithe::write_csv(table_, path); }
void Recorder::write_binary(const std::string& path) const { lithe::write_binary(table_, path); }
void Recorder::write_hdf5(const std::string& path) const { lithe::write_hdf5(table_, path); }

}  // namespace lithe
