#pragma once

#include <optional>
#include <vector>

#include "engine/assembly/batch.h"
#include "engine/plugin/plugin_type.h"

namespace lithe {

/// A body whose class is behind a C table.
class BodyFromC final : public Body {
 public:
  struct Parameters {
    const BodyType* type = nullptr;
    ParameterList values{};
  };
  /// What the plug-in's class caches, and whether it asked for a smaller step.
  struct Cache : BodyCache {
    explicit Cache(const BodyFromC& body);
    std::unique_ptr<void, void (*)(void*)> theirs;
    std::vector<Matrix3> rotations;  // of several frames
    bool retry = false;
  };

  /// Throws SceneError: wrong parameters.
  explicit BodyFromC(Parameters parameters);

  /// A frame at `position`, at a node, at the mean of nodes; axes `orientation`, marker axes to body axes. Each throws
  /// SceneError if the type makes no such markers, or refuses this one.
  Marker marker(const Point& position = {}, const Matrix3& orientation = Matrix3::Identity());
  Marker node(int number, const Matrix3& orientation = Matrix3::Identity());
  Marker average(const std::vector<int>& nodes, const Matrix3& orientation = Matrix3::Identity());

  /// A frame at `point` of the world as drawn (m), with axes `orientation` (marker axes to world axes). SceneError for
  /// a body without frame: what is made of nodes has markers at nodes.
  Marker marker_at_world(const Point& point, const Matrix3& orientation = Matrix3::Identity());

  Coordinates coordinates() const override { return coordinates_; }
  std::unique_ptr<BodyCache> make_cache() const override { return std::make_unique<Cache>(*this); }
  void initial_state(VectorRef q, VectorRef v) const override;
  void evaluate(const BodyState&, Level) const override;
  void add_residual(const BodyState&, const double* v_dot, const Vector3& gravity, double* r) const override;
  void add_tangent(const BodyState&, const double* v_dot, const Vector3& gravity, const TangentWeights&,
                   BodyTangent&) const override;
  void marker_kinematics(const BodyState&, int marker, Level, MarkerKinematics&) const override;
  BodyEnergy energy(const BodyState&, const Vector3& gravity) const override;

 private:
  template <class Call>
  bool call(const BodyState& state, Call&& function) const;
  void count_markers();
  template <class Function, class... Place>
  Marker made_marker(Function function, const char* where_at, const Place&... place);

  const lithe_body_type table_;
  const PluginObject object_;
  Coordinates coordinates_;
  LinearPattern pattern_;
  std::vector<FramePair> pairs_;
};

extern template std::unique_ptr<BodyBatch> make_body_batch<BodyFromC>();

}  // namespace lithe
