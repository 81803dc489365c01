#pragma once

#include <memory>
#include <string>

#include "models/fmu/fmu_contents_internal.h"
#include "models/fmu/fmu_library_internal.h"
#include "models/fmu/fmu_package_internal.h"

namespace lithe {

class Archive;

/// An FMU as a scene uses it: unpacked, read for one kind, its variables by the names that the scene gives them.
class FmuFile {
 public:
  /// `name` is for messages; empty: the model's. Throws FileError as FmuPackage and read_fmu_contents() do, SceneError
  /// for an FMU that needs the tool that made it.
  FmuFile(const std::string& path, FmuKind kind, std::string name);

  const std::string& name() const { return name_; }
  const FmuContents& contents() const { return contents_; }
  std::unique_ptr<FmuLibrary> make_instance() const;

  enum class Role { input, output, parameter, any };  // a parameter may be an input too: at the start
  /// `name`, or of an array name[i], i from 1. Throws SceneError for one that is not there, of another role or no
  /// single number.
  FmuNumber find(const std::string& name, Role role) const;
  /// Throws SceneError for a value that is not finite, or that find() refuses.
  FmuNumber find_parameter(const std::string& name, double value) const;

  [[noreturn]] void refuse(const std::string& problem, const std::string& fix) const;
  /// SimulationError where the unit gives a value that is not finite.
  double checked(const std::string& variable, double value) const;
  /// The instance's state in a checkpoint; null: it has none yet. Gives it anew when loading. Throws SceneError for an
  /// FMU that cannot give its state.
  void history(Archive& archive, std::unique_ptr<FmuLibrary>& instance, bool begun) const;
  /// Parts of what describe() says: FMI version and tool;
  std::string title() const;
  /// Of a variable: the values given to it at the start, or its default if it waits for one and is not connected.
  std::string values_of(const ImportedVariable& variable, const std::vector<std::pair<std::string, double>>& values,
                        bool connected) const;
  /// " [i]" where `name` is that of an entry of the variable.
  static std::string entry(const std::string& name, const ImportedVariable& variable);
  static std::string line(const ImportedVariable& variable, const std::string& is);

 private:
  const FmuPackage package_;
  const FmuKind kind_;
  const FmuContents contents_;
  const std::string name_;
};

}  // namespace lithe
