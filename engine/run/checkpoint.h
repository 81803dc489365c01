#pragma once

#include <string>

#include "engine/archive/archive.h"
#include "engine/observe/observer.h"

namespace lithe {

class System;

/// A checkpoint as an HDF5 file: the archive's content, the versions of format and Lithe, size and order of bytes, and
/// a digest of all of it. The file appears under its name only when complete: a kill leaves the old one or the new one.
/// Throws FileError if it cannot be written.
void write_checkpoint(const Archive& archive, const std::string& path);

/// To be loaded from. Throws FileError for a file that is none, is damaged or cut, of another format, of another
/// version of Lithe, or of other numbers.
Archive read_checkpoint(const std::string& path);

/// What a scene is: names, types and markers of its elements, and what its equations say at a state made up for it,
/// body by body and row by row.
class SceneFingerprint {
 public:
  explicit SceneFingerprint(const System& system);
  /// Saved; when loading, SceneError names what is another one now: a number of bodies, an element, a parameter of one.
  void same(Archive& archive) const;

 private:
  void same_elements(Archive& archive) const;
  bool sample(double away);

  const System& system_;
  std::vector<std::string> elements_;
  VectorX initial_;  // q, v as drawn
  VectorX own_;      // of bodies: M times a mixture, by velocity
  VectorX energy_;   // of bodies: kinetic, elastic, of gravity; then of forces
  VectorX rows_;     // of constraints: g, then its rate, then its bias
  VectorX all_;      // residual of the equations of motion
};

/// When checkpoints are due in a run: at its first state, then after the first step that reaches the next time. Steps
/// are not cut for them.
class CheckpointSchedule {
 public:
  CheckpointSchedule() = default;
  CheckpointSchedule(std::string path, Schedule schedule) : path_(std::move(path)), schedule_(schedule) {}

  const std::string& path() const { return path_; }
  /// As of observers: it begins at `time` if it is new, or in any case.
  void begin(double time, bool anew);
  /// Whether one is due; then it counts as written.
  bool pass(double time);
  void history(Archive& archive);

 private:
  std::string path_;  // empty: none wanted
  Schedule schedule_{};
  bool begun_ = false;
  double origin_ = 0, last_ = 0;  // s: of the schedule, of the last one
  long next_ = 0;                 // intervals after the origin
};

}  // namespace lithe
