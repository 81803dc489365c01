#pragma once

#include <vector>

#include "engine/assembly/batch.h"
#include "engine/model/joint_coordinate.h"
#include "engine/model/planar_body.h"
#include "engine/model/rigid_frame_body.h"

/// What takes the place of a user's elements in a scene made smaller (engine/simplify/simplification.h).
namespace lithe {

/// Rigid bodies welded together: one rigid body, its frame at the common centre of mass.
class RigidStandIn final : public RigidFrameBody {
 public:
  struct Parameters {
    RigidInertia inertia{1, Matrix3::Identity()};
    Start start{};
  };

  explicit RigidStandIn(Parameters parameters) : RigidFrameBody(parameters.inertia, parameters.start) {}
  /// `pose` in body axes, from the centre of mass.
  Marker marker(const FramePose& pose) { return place_marker(pose.position, pose.axes); }
};

/// A rigid body that its joints hold in a plane: q = (x, y, θ), its centre of mass along two axes of the plane, counted
/// from the origin of the world, and its turn about the normal since the reference pose.
///   m ẍ = f_x,  m ÿ = f_y,  J θ̈ = t   (J about the normal: constant)
class PlanarStandIn final : public PlanarBody {
 public:
  struct Parameters {
    Plane plane{};
    FramePose reference{};                   // of the rigid body at θ = 0
    Vector3 start{0, 0, 0}, rates{0, 0, 0};  // x, y, θ and their rates as drawn
  };
  /// The columns of a marker's Jacobian turn with θ.
  struct Arm final : DeflectedMarker {
    Vector3 normal, at;  // from the centre of mass, world axes
    double columns[18];
    explicit Arm(const Matrix3& axes);
    void add_load_stiffness(const Vector3& force, const Vector3& torque, double* linear) const override;
  };
  struct Cache : BodyCache {
    Matrix3 turn = Matrix3::Identity();
    std::vector<Arm> arms;
    explicit Cache(const PlanarStandIn& body) : arms(body.markers_.size(), Arm(body.plane().axes)) {}
  };

  explicit PlanarStandIn(const Parameters& parameters) : PlanarBody(parameters.plane), parameters_(parameters) {}
  /// `pose` in world axes, at the reference.
  Marker marker(const FramePose& pose);

  Coordinates coordinates() const override { return {.frames = 0, .linear = 3}; }
  std::unique_ptr<BodyCache> make_cache() const override { return std::make_unique<Cache>(*this); }
  void initial_state(VectorRef q, VectorRef v) const override { q = parameters_.start, v = parameters_.rates; }
  void evaluate(const BodyState&, Level) const override;
  void add_residual(const BodyState&, const double* v_dot, const Vector3& gravity, double* r) const override;
  void add_tangent(const BodyState&, const double* v_dot, const Vector3& gravity, const TangentWeights&,
                   BodyTangent&) const override;
  void marker_kinematics(const BodyState&, int marker, Level, MarkerKinematics&) const override;
  BodyEnergy energy(const BodyState&, const Vector3& gravity) const override;

 private:
  Matrix3 turn(double angle) const;

  const Parameters parameters_;
  std::vector<FramePose> markers_;  // arm from the centre of mass, and axes, at the reference
};

/// Some rows of a constraint between planar stand-ins and ground: the others say nothing in the plane.
class RowsInPlane final : public Constraint {
 public:
  struct Parameters {
    Constraint* whole = nullptr;
    std::vector<int> rows{};
  };
  explicit RowsInPlane(Parameters parameters) : parameters_(std::move(parameters)) {}

  const Constraint& whole() const { return *parameters_.whole; }
  int marker_count() const override { return parameters_.whole->marker_count(); }
  int row_count() const override { return static_cast<int>(parameters_.rows.size()); }
  void initialize(std::span<const MarkerView> markers) override { parameters_.whole->initialize(markers); }
  std::vector<MeasuredAngle> angles() const override { return parameters_.whole->angles(); }
  std::optional<JointFreedom> freedom() const override { return parameters_.whole->freedom(); }
  void evaluate(double time, std::span<const MarkerView> markers, ConstraintRows& rows) const override;

 private:
  const Parameters parameters_;
};

/// A force element whose switches are to be watched at other markers.
class MovedForce final : public ForceElement {
 public:
  struct Parameters {
    ForceElement* whole = nullptr;
    std::vector<CoordinateSwitch> switches{};
  };
  explicit MovedForce(Parameters parameters) : parameters_(std::move(parameters)) {}

  int marker_count() const override { return parameters_.whole->marker_count(); }
  int row_count() const override { return parameters_.whole->row_count(); }
  void initialize(std::span<const MarkerView> markers) override { parameters_.whole->initialize(markers); }
  std::vector<MeasuredAngle> angles() const override { return parameters_.whole->angles(); }
  void evaluate(double time, std::span<const MarkerView> markers, ForceRows& rows) const override {
    parameters_.whole->evaluate(time, markers, rows);
  }
  const Constraint* reaction_of() const override { return parameters_.whole->reaction_of(); }
  std::vector<CoordinateSwitch> switches() const override { return parameters_.switches; }

 private:
  const Parameters parameters_;
};

/// Counts the turns of a constraint that has no rows left.
class TurnCount final : public ForceElement {
 public:
  struct Parameters {
    const Constraint* of = nullptr;
  };
  explicit TurnCount(Parameters parameters) : of_(*parameters.of) {}

  int marker_count() const override { return of_.marker_count(); }
  int row_count() const override { return 0; }
  std::vector<MeasuredAngle> angles() const override { return of_.angles(); }
  void evaluate(double, std::span<const MarkerView>, ForceRows&) const override {}

 private:
  const Constraint& of_;
};

extern template std::unique_ptr<BodyBatch> make_body_batch<RigidStandIn>();
extern template std::unique_ptr<BodyBatch> make_body_batch<PlanarStandIn>();
extern template std::unique_ptr<ConstraintBatch> make_constraint_batch<RowsInPlane>();
extern template std::unique_ptr<ForceBatch> make_force_batch<MovedForce>();
extern template std::unique_ptr<ForceBatch> make_force_batch<TurnCount>();

}  // namespace lithe
