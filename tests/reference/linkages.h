#pragma once

#include <string>
#include <vector>

#include "tests/reference/mechanism.h"
#include "tests/support/scenes.h"

/// Linkages with one freedom, in a plane or over-constrained in space, drawn with any joints that admit their motion.
namespace lithe::test {

/// A linkage before joints are chosen; most lie in the plane z = 0.
struct Linkage {
  struct Link {
    std::string name;
    Vector3 a, b;    // ends, m; a block if they are equal
    double mass;     // kg
    Vector3 va, vb;  // about their velocities, m/s: assemble() makes them consistent
  };
  struct Hinge {
    int A, B;  // links; -1: ground
    Vector3 at;
    Vector3 axis = Vector3::UnitZ();
  };
  struct Slide {
    int link;
    Vector3 at, direction;
  };
  std::string name;
  std::vector<Link> links;
  std::vector<Hinge> hinges;
  std::vector<Slide> slides;
  double duration;  // s; of two turns at least where it turns
};

enum class HingeAs { revolute, cylindrical, universal, spherical };
enum class SlideAs { prismatic, cylindrical, on_line };

/// One choice of joints, in the order of the linkage's hinges and slides.
struct Drawing {
  std::vector<HingeAs> hinges;
  std::vector<SlideAs> slides;
  std::string name() const;
};

Linkage slider_crank();
Linkage four_bar();
Linkage scott_russell();
Linkage parallelogram();
Linkage scissor();
Linkage bennett();
Linkage bricard();

/// What a choice of joints leaves free besides what revolute and prismatic ones do.
int freedoms_added(const Drawing& drawing);

/// Every choice of joints for a linkage, the plainest (revolute, prismatic) first.
std::vector<Drawing> all_drawings(const Linkage& linkage);

/// World velocity and angular velocity of each link, as the plainest drawing has them at the start.
std::vector<Vector6> start_velocities(const Linkage& linkage);

/// The linkage turned by `turn` as a whole, gravity with it.
Scene draw(const Linkage& linkage, const Drawing& drawing, const Matrix3& turn, const std::vector<Vector6>& velocities);

}  // namespace lithe::test
