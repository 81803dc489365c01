#pragma once

#include <array>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "bodies/beam/slender_body.h"
#include "bodies/flexible/finite_element_model.h"
#include "bodies/flexible/flexible_body.h"
#include "bodies/rigid_body.h"
#include "engine/model/system_graph.h"

namespace lithe {

class InertialBody;  // of the plug-in inertial_body, compiled in

}  // namespace lithe

namespace lithe::certify {

using SolidModel = std::shared_ptr<const FiniteElementModel>;

/// A bar of bricks with incompatible modes (C3D8I) along x, a corner at the mesh origin; its faces are the node sets
/// x0, x1, y0, y1, z0, z1.
SolidModel bar(const Vector3& size, const std::array<int, 3>& divisions, const Material& material);
/// Labels of the nodes at which `chosen` (mesh axes, m) holds.
std::vector<int> nodes_where(const FiniteElementModel& model, const std::function<bool(const Vector3&)>& chosen);
/// Label of the node nearest to a point (mesh axes, m).
int node_at(const FiniteElementModel& model, const Vector3& point);

/// An elastic part as a scene describes it, whatever models it.
struct ElasticPartParameters {
  SolidModel solid;
  BodyFrame frame = MeanAxisFrame{};          // of the modes
  int eigenmodes = 10;                        // candidates beside the static ones of the interfaces
  std::vector<std::vector<int>> loaded{};     // interfaces held by their mean
  Deflection finest = Deflection::quadratic;  // linear: small motions of elements that know no other
  double stiffness_damping = 0;               // s
  Vector3 position{0, 0, 0};                  // of the mesh origin at t = 0, world axes, m
  Matrix3 orientation = Matrix3::Identity();  // mesh axes to world axes
  Vector3 velocity{0, 0, 0};                  // of the mesh origin, world axes, m/s
  Vector3 angular_velocity{0, 0, 0};          // mesh axes, rad/s
};

/// An elastic part in a graph. Orientations of its markers are those of the drawing, in world axes.
class ElasticPart {
 public:
  ElasticPart(FlexibleBody* modes, InertialBody* bricks, ElasticPartParameters parameters)
      : modes_(modes), bricks_(bricks), parameters_(std::move(parameters)) {}

  Marker average(const std::vector<int>& ids, const Matrix3& axes = Matrix3::Identity());
  Marker average(const std::string& set, const Matrix3& axes = Matrix3::Identity()) { return average(ids(set), axes); }
  Marker node(int id);

  const FiniteElementModel& solid() const { return *parameters_.solid; }
  const std::vector<int>& ids(const std::string& set) const { return solid().node_set(set); }
  Vector3 place(int id) const;                        // as drawn, world axes, m
  Vector3 middle(const std::vector<int>& ids) const;  // likewise, of the mean
  Vector3 middle(const std::string& set) const { return middle(ids(set)); }
  double mass() const;  // kg
  bool is_bricks() const { return bricks_ != nullptr; }

 private:
  FlexibleBody* modes_;
  InertialBody* bricks_;
  ElasticPartParameters parameters_;
};

/// Makes the elastic parts of a scene of one kind; keeps what it has reduced for the next drawing.
class ElasticParts {
 public:
  enum class Kind {
    modes,   // FlexibleBody, on a basis with quadratic deflection
    bricks,  // InertialBody: large rotation and deflection in the inertial frame, the reference
  };
  explicit ElasticParts(Kind kind) : kind_(kind) {}

  // Of modes: the first so many of the candidates of every part, and how they deflect; beams may be exact.
  int mode_count = FlexibleBody::kAll;
  Deflection deflection = Deflection::quadratic;
  int more_eigenmodes = 0;  // candidates beside those asked for: for references
  int elements = 0;         // of beams; 0: as drawn

  ElasticPart add(SystemGraph& graph, const std::string& name, ElasticPartParameters parameters);
  /// A beam: of modes or exact; of bricks it is exact, with `elements`.
  SlenderBody& add_beam(SystemGraph& graph, const std::string& name, SlenderBody::Parameters parameters);

 private:
  struct Bases {
    std::shared_ptr<const ModalBasis> linear, stiffened, quadratic;
  };
  const Bases& reduced(const std::string& name, const ElasticPartParameters& parameters);

  Kind kind_;
  std::map<std::string, Bases> bases_;
};

/// Makes markers of a rigid body, or of ground, at places and in axes of the drawing (world axes).
using Places = std::function<Marker(const Vector3& place, const Matrix3& axes)>;
Places on(Ground& ground);
Places on(RigidBody& body);

/// Axes of which z lies along `direction`.
Matrix3 axes_along(const Vector3& direction);

/// Ties a part at nodes to a rigid holder, each where it is: off one line a clamp, on a line a hinge about it. The
/// part's frame must hold these nodes (TangentFrame, HingeFrame): then a joint at their mean does the same for modes.
void hold(SystemGraph& graph, const std::string& name, const Places& holder, ElasticPart& part,
          const std::vector<int>& ids);

}  // namespace lithe::certify
