#pragma once

#include <functional>
#include <string>
#include <vector>

#include "engine/base/error.h"
#include "engine/output/table.h"
#include "engine/study/progress.h"
#include "engine/study/sweep_parameters.h"

namespace lithe {

/// One choice of the parameters.
class SweepPoint {
 public:
  SweepPoint(const Table& parameters, int row) : parameters_(parameters), row_(row) {}

  int row() const { return row_; }  // its place in the table, from 0
  /// The value of a parameter. Throws SceneError that lists the known.
  double operator[](const Located& parameter) const;
  std::string text() const;  // "point 3 (length 0.5, mass 2)"

 private:
  const Table& parameters_;
  int row_;
  mutable std::size_t next_ = 0;  // column after the one asked for last: scenes mostly ask in order
};

/// What a point comes to: {{"period", 2.1}, {"largest_force", 13.5}}. NaN: there is no such number at this point.
struct SweepValue {
  std::string name;
  double value = 0;
};
using SweepValues = std::vector<SweepValue>;

/// A scene as a function of its parameters: draws a graph of its own, runs it, and says what it came to. It is called
/// from several threads at once, so it shares with other calls only what nobody changes (a model read before, a basis).
using SweepScene = std::function<SweepValues(const SweepPoint&)>;

struct SweepOptions {
  int threads = 0;  // 0: all processors that this process may use
  Progress::Show progress = Progress::Show::on_terminal;
  /// Where the table is kept while points are computed, as write_csv() writes it; empty: nowhere. Points that are not
  /// done have that as their error. It is what a killed rank or a lost node leaves behind; points that ended within
  /// twenty times what writing it takes may be missing. FileError, before any point, where it cannot be written; later
  /// a warning: the table returned is whole.
  std::string file{};
};

/// Why a point has no results.
struct SweepFailure {
  int row = 0;
  std::string point;  // "point 3 (length 0.5, mass 2)"
  std::string what, where, fix;
};

struct SweepResult {
  Table table{};                         // parameters, then results, in the order of the points; NaN where one failed
  std::vector<SweepFailure> failures{};  // in the same order
  int rank = 0;                          // this process among those of mpirun: rank 0 writes files and prints

  /// "2 of 40 points failed", and why: the first ten.
  std::string report() const;
  /// The table; what is NaN is an empty cell. If a point failed, a last column "error" says why. Under mpirun rank 0
  /// alone writes. Throws FileError.
  void write_csv(const std::string& path) const;
};

/// Runs a scene at every point, on all processors; points are handed out as threads become free. Each is computed by
/// one thread alone, so the table does not depend on how many there are, to the last bit. A point that fails leaves the
/// others alone: its row is NaN, its error kept. All points must name the same results, in the same order.
///   Started by `mpirun -n 4 program`, the ranks share the points (rank 0 deals them out), and each returns the whole
/// table, so that what follows needs no distinction but who writes: rank 0. All ranks must run the same sweeps, from
/// one thread; a rank that ends before takes the others with it. Results are those of one rank to the last bit, on
/// processors alike.
///   A sweep within a point runs on that point's thread. Throws SceneError: no scene, no points, parameters without a
/// name or twice named, a value that is not finite.
SweepResult sweep(const SweepScene& scene, const Table& parameters, const SweepOptions& options = {});

}  // namespace lithe
