#pragma once

#include <source_location>
#include <string>
#include <vector>

#include "engine/observer.h"
#include "engine/output/table.h"
#include "engine/sensors.h"

namespace lithe {

/// Keeps what sensors read, one row a state: time in column "t", then the sensors' columns in their order.
class Recorder final : public Observer {
 public:
  /// Throws SceneError if two columns bear the same name.
  explicit Recorder(std::vector<Sensor> sensors, std::source_location where = std::source_location::current());

  /// Throws SimulationError, the row not added, for a value that is no finite number.
  void observe(Snapshot& snapshot) override;

  const Table& table() const { return table_; }
  void write_csv(const std::string& path) const;     // engine/output/csv.h
  void write_binary(const std::string& path) const;  // engine/output/binary.h
  void write_hdf5(const std::string& path) const;    // engine/output/hdf5_table.h

 private:
  std::vector<Sensor> sensors_;
  Table table_;
  std::vector<double> row_;
};

}  // namespace lithe
