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

/// Keeps what sensors read, one row a state: time in column "t", then the sensors' columns in their order.
class Recorder final : public Observer {
 public:
  /// Throws SceneError if two columns bear the same name.
  explicit Recorder(std::vector<Sensor> sensors, std::source_location where = std::source_location::current());
  ~Recorder() override;

  /// Throws SimulationError, the row not added, for a value that is not finite.
  void observe(Snapshot& snapshot) override;

  /// Writes each row into a file too, as soon as it is there: what a run that is killed leaves. ".csv": a line a row,
  /// handed to the operating system at once; ".h5": as write_hdf5() would, growing (engine/output/hdf5_series.h). The
  /// file is begun at the first row, in the place of one of that name; where a run is resumed it is cut back to the
  /// checkpoint and goes on. Throws SceneError for another ending, or once there are rows.
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
