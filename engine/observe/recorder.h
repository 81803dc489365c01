#pragma once

#include <memory>
#include <source_location>
#include <string>
#include <vector>

#include "engine/observe/observer.h"
#include "engine/observe/sensors.h"
#include "engine/output/table.h"

namespace lithe {

class TableStream;

/// Records sensors, one row per state: time in column "t", then the sensors' columns in their order.
class Recorder final : public Observer {
 public:
  /// Throws SceneError if two columns have the same name.
  explicit Recorder(std::vector<Sensor> sensors, std::source_location where = std::source_location::current());
  ~Recorder() override;

  /// Throws SimulationError, the row not added, for a value that is not finite.
  void observe(Snapshot& snapshot) override;

  /// Also writes each row into a file at once, so that a killed run leaves its rows. ".csv": one line per row,
  /// passed to the operating system at once; ".h5": as write_hdf5() would, growing (engine/output/hdf5_series.h). The
  /// first row begins the file and replaces one of that name; a resumed run truncates it at the checkpoint and
  /// continues it. Throws SceneError for another ending, or once there are rows.
  void stream(const std::string& path);
  /// Its rows; of one that streams how many, to be read back from its file.
  void history(Archive& archive) override;

  const Table& table() const { return table_; }
  void write_csv(const std::string& path) const;     // engine/output/csv.h
  void write_binary(const std::string& path) const;  // engine/output/binary.h
  void write_hdf5(const std::string& path) const;    // engine/output/hdf5_table.h

 private:
  std::vector<Sensor> sensors_;
  Table table_;
  std::vector<double> row_;
  std::unique_ptr<TableStream> stream_;  // null: in memory alone
};

}  // namespace lithe
