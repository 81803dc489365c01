#pragma once

#include <vector>

#include "engine/base/math.h"
#include "engine/model/constraint.h"

namespace lithe {

/// A scene of rigid bodies, in space or in planes normal to one world axis, and lower pairs alone, as the kernels of
/// forward dynamics see it.
struct RigidScene {
  struct Body {
    int q, v;  // first coordinate and velocity
    double mass;
    Matrix3 inertia;        // body axes
    bool in_plane = false;  // its coordinates are those of a PlanarBody; body axes are those of the world at t = 0
    int normal = -1;        // of the plane: a world axis
  };
  struct Side {
    int body;          // index, -1: ground
    Vector3 position;  // of the marker in its body's axes, from the centre of mass; world axes on the ground
    Matrix3 axes;      // marker axes to those
  };
  struct Joint {
    Side A, B;
    JointFreedom freedom;
  };
  std::vector<Body> bodies;
  std::vector<Joint> joints;
  Vector3 gravity;
  VectorX q;        // at t = 0, on the constraints
  int threads = 1;  // that a kernel may use
};

/// How accelerations without multipliers are found: joint by joint along a tree, in a plane, or as all else by
/// eliminating bodies with constraints.
enum class ForwardMethod { constraints, tree, planar };

/// Forward dynamics of one kind of rigid scene: scratch of its own, one a thread.
class ForwardKernel {
 public:
  virtual ~ForwardKernel() = default;
  virtual ForwardMethod method() const = 0;
  /// `load`: generalized forces besides gravity (world axes; torques in body axes), null for none.
  virtual void accelerations(const double* q, const double* v, const double* load, double* v_dot) = 0;
  virtual bool project(double* q, double* v, double tolerance) = 0;
};

}  // namespace lithe
