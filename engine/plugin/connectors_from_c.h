#pragma once

#include "engine/assembly/batch.h"
#include "engine/plugin/plugin_type.h"

/// Joints and forces whose class is behind a C table. One indirect call per element, none per scalar; their rows are
/// those of the class, bit for bit.
namespace lithe {

class JointFromC final : public Constraint {
 public:
  struct Parameters {
    const JointType* type = nullptr;
    ParameterList values{};
  };
  /// Throws SceneError: wrong parameters.
  explicit JointFromC(Parameters parameters);

  int marker_count() const override { return table_.marker_count; }
  int row_count() const override { return table_.row_count; }
  /// Rows of NaN where the joint asks for a smaller step. Throws SimulationError where it fails.
  void evaluate(double time, std::span<const MarkerView> markers, ConstraintRows& rows) const override;
  void initialize(std::span<const MarkerView> markers) override;
  std::vector<MeasuredAngle> angles() const override { return angles_; }

 private:
  const lithe_joint_type table_;
  const PluginObject object_;
  const std::vector<MeasuredAngle> angles_;
};

/// (In v1 of the interface a force does not get a joint's reaction.)
class ForceFromC final : public ForceElement {
 public:
  struct Parameters {
    const ForceType* type = nullptr;
    ParameterList values{};
  };
  /// Throws SceneError: wrong parameters.
  explicit ForceFromC(Parameters parameters);

  int marker_count() const override { return table_.marker_count; }
  int row_count() const override { return table_.row_count; }
  /// Loads of NaN where the force asks for a smaller step. Throws SimulationError where it fails.
  void evaluate(double time, std::span<const MarkerView> markers, ForceRows& rows) const override;
  void initialize(std::span<const MarkerView> markers) override;
  std::vector<MeasuredAngle> angles() const override { return angles_; }

 private:
  const lithe_force_type table_;
  const PluginObject object_;
  const std::vector<MeasuredAngle> angles_;
};

extern template std::unique_ptr<ConstraintBatch> make_constraint_batch<JointFromC>();
extern template std::unique_ptr<ForceBatch> make_force_batch<ForceFromC>();

}  // namespace lithe
