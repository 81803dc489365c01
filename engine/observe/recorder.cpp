#include "engine/observe/recorder.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "engine/archive/archive.h"
#include "engine/base/number_text.h"
#include "engine/output/binary.h"
#include "engine/output/csv.h"
#include "engine/output/hdf5_table.h"
#include "engine/output/table_stream.h"

namespace lithe {
Recorder::Recorder(std::vector<Sensor> sensors, std::source_location where) try : sensors_(std::move(sensors)) {
  std::map<std::string, std::string> taken{{"t", "the time"}};
  table_.columns.push_back("t");
  for (const Sensor& sensor : sensors_)
    for (const std::string& column : sensor.columns()) {
      const auto [other, fresh] = taken.try_emplace(column, "the sensor of " + sensor.where());
      if (!fresh)
        throw SceneError("two columns of a recorder are called '" + column + "': " + other->second + " has it too",
                         sensor.where() + ", recorder of " + to_string(where),
                         "name one of the sensors, as in height(marker, \"tip\"); give one of your own other columns");
      table_.columns.push_back(column);
    }
  row_.resize(table_.columns.size());
} catch (...) {
  rethrow_as_error("the recorder", to_string(where), "see what it says");
}

void Recorder::observe(Snapshot& snapshot) {
  std::fill(row_.begin(), row_.end(), std::numeric_limits<double>::quiet_NaN());  // a column forgotten is seen
  row_[0] = snapshot.time();
  std::span<double> rest = std::span(row_).subspan(1);
  for (const Sensor& sensor : sensors_) {
    const auto values = rest.first(sensor.columns().size());
    try {
      sensor.evaluate(snapshot, values);
    } catch (...) {
      rethrow_as_error("sensor '" + sensor.name() + "'", sensor.where() + ", " + time_text(snapshot.time()),
                       "see what it reads; rows up to then are kept");
    }
    for (std::size_t i = 0; i < values.size(); ++i)
      if (!std::isfinite(values[i]))
        throw SimulationError("sensor '" + sensor.columns()[i] + "' reads " + std::to_string(values[i]) + " at " +
                                  time_text(snapshot.time()),
                              sensor.where(), "see what it divides by or takes the root of; rows up to then are kept");
    rest = rest.subspan(values.size());
  }
  table_.add_row(row_);
  if (!stream_) return;
  try {
    stream_->append(table_.columns, row_);
  } catch (...) {  // the row is in neither place: a run that goes on tells it again
    table_.values.resize(table_.values.size() - row_.size());
    throw;
  }
}

Recorder::~Recorder() = default;

void Recorder::stream(const std::string& path) {
  if (!table_.values.empty())
    throw SceneError(
        "a recorder that has " + std::to_string(table_.row_count()) + " rows already cannot begin '" + path + "'",
        "Recorder::stream", "call stream() before the run, or write_csv() after it");
  stream_ = std::make_unique<TableStream>(path);
}

void Recorder::history(Archive& archive) {
  std::vector<std::string> columns = table_.columns;
  archive("columns", columns);
  if (columns != table_.columns)
    throw SceneError("the recorder where the checkpoint was written had other columns", archive.source(),
                     "resume with the same recorders, observed in the same order");
  int rows = table_.row_count();
  bool streams = stream_ != nullptr;
  archive("rows", rows);
  archive("streams", streams);
  if (streams && archive.loads() && !stream_)
    throw SceneError("the recorder where the checkpoint was written kept its rows in a file", archive.source(),
                     "call stream() with the path of that file before resume()");
  if (!streams)
    archive("values", table_.values);
  else if (archive.loads())
    table_ = stream_->go_on(table_.columns, rows);
  // A run that kept its rows in memory goes on into a file.
  if (!streams && stream_ && archive.loads()) stream_->begin(table_);
}

void Recorder::write_csv(const std::string& path) const { lithe::write_csv(table_, path); }
void Recorder::write_binary(const std::string& path) const { lithe::write_binary(table_, path); }
void Recorder::write_hdf5(const std::string& path) const { lithe::write_hdf5(table_, path); }

}  // namespace lithe
