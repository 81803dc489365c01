#include "tools/contact/bullet_stepper.h"

#include <BulletDynamics/ConstraintSolver/btNNCGConstraintSolver.h>
#include <BulletDynamics/MLCPSolvers/btDantzigSolver.h>
#include <BulletDynamics/MLCPSolvers/btLemkeSolver.h>
#include <BulletDynamics/MLCPSolvers/btMLCPSolver.h>
#include <btBulletDynamicsCommon.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>

#include "engine/base/checks.h"
#include "engine/base/error.h"
#include "engine/model/rigid_frame_body.h"
#include "engine/motion/projection.h"
#include "joints/contact/contact.h"
#include "joints/contact/shape_internal.h"
#include "joints/fixed_joint.h"
#include "joints/prismatic_joint.h"
#include "joints/revolute_joint.h"
#include "joints/spherical_joint.h"

namespace lithe {
namespace bullet_stepper {

[[noreturn]] void refuse(const Element& element, const std::string& what, const std::string& fix) {
  throw SceneError("'" + element.name() + "' " + what, element.where(), fix);
}

/// What may meet: pairs of one contact element whose groups agree, one of them moving.
struct Filter final : btOverlapFilterCallback {
  bool needBroadphaseCollision(btBroadphaseProxy* a, btBroadphaseProxy* b) const override {
    const auto *A = static_cast<btCollisionObject*>(a->m_clientObject),
               *B = static_cast<btCollisionObject*>(b->m_clientObject);
    if (A->getUserIndex() != B->getUserIndex() || A->getUserIndex() < 0) return false;
    if (A->isStaticObject() && B->isStaticObject()) return false;
    return (a->m_collisionFilterGroup & b->m_collisionFilterMask) &&
           (b->m_collisionFilterGroup & a->m_collisionFilterMask);
  }
};

/// Bullet wants bodies in principal axes: these, to the body's own.
Matrix3 principal_axes(const Matrix3& inertia) {
  if (Matrix3(inertia.diagonal().asDiagonal()) == inertia) return Matrix3::Identity();
  Matrix3 axes = Eigen::SelfAdjointEigenSolver<Matrix3>(inertia).eigenvectors();
  if (axes.determinant() < 0) axes.col(2) *= -1;
  return axes;
}

/// Shapes on one body as Bullet would have them, with its margins.
class Geometry {
 public:
  explicit Geometry(double margin) : margin_(margin) {}

  struct Piece {
    btTransform at;
    btCollisionShape* shape;
    bool convex;
  };
  /// Appends the pieces of `shape`, at `pose` of its body.
  void add(const Element& contact, const Shape& shape, const btTransform& pose, std::vector<Piece>& pieces) {
    const Shape::Data& data = shape.data();
    switch (data.kind) {
      case Shape::Kind::compound:
        for (const auto& [placement, part] : data.parts)
          add(contact, part, pose * to_bullet(placement.position, placement.orientation), pieces);
        return;
      case Shape::Kind::surface:
        refuse(contact, "has a deforming surface", "Bullet's stepper knows rigid shapes: use MoreauJean");
      case Shape::Kind::half_space:
        pieces.push_back({pose, keep(std::make_unique<btStaticPlaneShape>(btVector3(0, 0, 1), 0)), false});
        return;
      case Shape::Kind::mesh:
      case Shape::Kind::height_field: {
        auto mesh = std::make_unique<btBvhTriangleMeshShape>(data.mesh.get(), /*useQuantizedAabbCompression=*/true);
        mesh->setMargin(margin_);
        pieces.push_back({pose, keep(std::move(mesh)), false});
        return;
      }
      default:
        pieces.push_back({pose, keep(copy(data)), true});
    }
  }
  /// One shape of pieces that move together.
  btCollisionShape* join(const std::vector<Piece>& pieces) {
    if (pieces.empty()) return keep(std::make_unique<btEmptyShape>());
    if (pieces.size() == 1 && pieces[0].at == btTransform::getIdentity()) return pieces[0].shape;
    auto all = std::make_unique<btCompoundShape>();
    for (const Piece& piece : pieces) all->addChildShape(piece.at, piece.shape);
    return keep(std::move(all));
  }

 private:
  btCollisionShape* keep(std::unique_ptr<btCollisionShape> shape) {
    shapes_.push_back(std::move(shape));
    return shapes_.back().get();
  }
  std::unique_ptr<btConvexShape> copy(const Shape::Data& data) const {
    const btConvexShape* shape = data.convex.get();
    const auto rounded = [&](std::unique_ptr<btConvexInternalShape> made, const btVector3& half) {
      made->setMargin(std::min(margin_, 0.1 * half[half.minAxis()]));
      return made;
    };
    switch (data.kind) {
      case Shape::Kind::sphere:
        return std::make_unique<btSphereShape>(static_cast<const btSphereShape*>(shape)->getRadius());
      case Shape::Kind::box: {
        const btVector3 half = static_cast<const btBoxShape*>(shape)->getHalfExtentsWithMargin();
        return rounded(std::make_unique<btBoxShape>(half), half);
      }
      case Shape::Kind::cylinder: {
        const btVector3 half = static_cast<const btCylinderShape*>(shape)->getHalfExtentsWithMargin();
        return rounded(std::make_unique<btCylinderShapeZ>(half), half);
      }
      case Shape::Kind::capsule: {
        const auto* capsule = static_cast<const btCapsuleShape*>(shape);
        return std::make_unique<btCapsuleShapeZ>(capsule->getRadius(), 2 * capsule->getHalfHeight());
      }
      case Shape::Kind::cone: {
        const auto* cone = static_cast<const btConeShape*>(shape);
        auto made = std::make_unique<btConeShapeZ>(cone->getRadius(), cone->getHeight());
        made->setMargin(margin_);
        return made;
      }
      default: {
        const auto* hull = static_cast<const btConvexHullShape*>(shape);
        auto made = std::make_unique<btConvexHullShape>(&hull->getUnscaledPoints()[0].x(), hull->getNumPoints(),
                                                        static_cast<int>(sizeof(btVector3)));
        made->setMargin(margin_);
        return made;
      }
    }
  }

  double margin_;
  std::vector<std::unique_ptr<btCollisionShape>> shapes_;
};

}  // namespace bullet_stepper

/// The scene as Bullet has it.
class BulletStepper::World {
 public:
  World(const System& system, const Parameters& parameters, const VectorX& q, const VectorX& v)
      : geometry_(parameters.margin) {
    make_world(system, parameters);
    add_bodies(system);
    find_pieces(system);
    for (Mover& mover : movers_) add(mover, q, v);
    for (const auto& c : system.graph().constraints()) add(*c.constraint, c.markers);
  }
  ~World() {
    for (const auto& joint : joints_) world_->removeConstraint(joint.get());
    for (const auto& body : bodies_) world_->removeRigidBody(body.get());
  }

  void step(double h) { world_->stepSimulation(h, 0); }
  /// `q` holds the coordinates before: of the two quaternions of a pose, the nearer one is taken.
  void read(VectorX& q, VectorX& v) const {
    for (const Mover& mover : movers_) {
      const btTransform& pose = mover.body->getWorldTransform();
      const btQuaternion turn = mover.turned ? pose.getRotation() * mover.back : pose.getRotation();
      Vector4 e(turn.w(), turn.x(), turn.y(), turn.z());
      e /= e.dot(q.segment<4>(mover.q + 3)) < 0 ? -e.norm() : e.norm();
      q.segment<3>(mover.q) = from_bullet(pose.getOrigin());
      q.segment<4>(mover.q + 3) = e;
      v.segment<3>(mover.v) = from_bullet(mover.body->getLinearVelocity());
      v.segment<3>(mover.v + 3) = mover.axes * from_bullet(mover.body->getAngularVelocity() * pose.getBasis());
    }
  }

 private:
  struct Mover {
    int q, v;
    const Body* of;
    RigidInertia inertia;
    Matrix3 axes;       // principal to body axes
    bool turned;        // they are not the body's
    btQuaternion back;  // body to principal axes
    std::vector<bullet_stepper::Geometry::Piece> pieces{};
    const Contact* contact = nullptr;
    int contact_index = -1;
    const Collider* collider = nullptr;  // the first one
    btRigidBody* body = nullptr;
  };

  void make_world(const System& system, const Parameters& parameters) {
    if (parameters.solver == Solver::dantzig)
      lcp_ = std::make_unique<btDantzigSolver>();
    else if (parameters.solver == Solver::lemke)
      lcp_ = std::make_unique<btLemkeSolver>();
    if (lcp_)
      solver_ = std::make_unique<btMLCPSolver>(lcp_.get());
    else if (parameters.solver == Solver::nncg)
      solver_ = std::make_unique<btNNCGConstraintSolver>();
    else
      solver_ = std::make_unique<btSequentialImpulseConstraintSolver>();
    world_ = std::make_unique<btDiscreteDynamicsWorld>(&dispatcher_, &broadphase_, solver_.get(), &configuration_);
    world_->getPairCache()->setOverlapFilterCallback(&filter_);
    world_->setGravity(to_bullet(system.gravity()));
    btContactSolverInfo& info = world_->getSolverInfo();
    info.m_numIterations = parameters.iterations;
    info.m_splitImpulse = parameters.split_impulse;
    info.m_restitutionVelocityThreshold = parameters.restitution_threshold;
    if (lcp_) info.m_minimumSolverBatchSize = 1;  // an island by itself: dense matrices
    ground_.setWorldTransform(btTransform::getIdentity());
  }

  void add_bodies(const System& system) {
    index_[system.graph().bodies().front().body] = -1;
    for (const auto& slice : system.layout().bodies()) {
      const auto* inertia = rigid_inertia_of(*slice.body);
      if (!inertia || !slice.frame || slice.linear > 0)
        bullet_stepper::refuse(*slice.body, "is not rigid", "Bullet's stepper knows rigid bodies: use MoreauJean");
      index_[slice.body] = static_cast<int>(movers_.size());
      Mover mover{slice.q, slice.v, slice.body, *inertia, bullet_stepper::principal_axes(inertia->inertia), false, {}};
      mover.turned = mover.axes != Matrix3::Identity();
      to_bullet(Vector3::Zero(), Matrix3(mover.axes.transpose())).getBasis().getRotation(mover.back);
      movers_.push_back(mover);
    }
  }

  /// Pose of a marker in the axes that Bullet has for its body.
  btTransform pose_of(const Marker& marker) const {
    static const double at_rest[7] = {0, 0, 0, 1, 0, 0, 0};
    const auto cache = marker.body->make_cache();
    const BodyState state{at_rest, at_rest, cache.get()};
    marker.body->evaluate(state, Level::position);
    MarkerKinematics k;
    marker.body->marker_kinematics(state, marker.index, Level::position, k);
    const int i = index_.at(marker.body);
    if (i < 0) return to_bullet(k.p, k.R);
    const Matrix3 back = movers_[i].axes.transpose();
    return to_bullet(Vector3(back * k.p), Matrix3(back * k.R));
  }

  void find_pieces(const System& system) {
    int contacts = 0;
    for (const auto& f : system.graph().forces())
      bullet_stepper::refuse(*f.force, "is a force that Bullet's stepper does not support",
                             "it supports gravity, contact and some joints: use MoreauJean");
    for (const auto& entry : system.graph().contacts()) {
      const auto* contact = dynamic_cast<const Contact*>(entry.contact);
      if (!contact)
        bullet_stepper::refuse(*entry.contact, "is a contact of a type that Bullet's stepper does not support",
                               "use joints/contact/contact.h");
      if (contact->law() == ContactElement::Law::sensing) continue;
      if (contact->law() == ContactElement::Law::compliant)
        bullet_stepper::refuse(*contact, "is compliant", "Bullet's stepper knows RigidSurfaces");
      const RigidContact law = contact->rigid();
      if (law.friction == 0 && (law.rolling > 0 || law.spinning > 0))
        bullet_stepper::refuse(*contact, "resists rolling or spinning without friction",
                               "Bullet multiplies these by the friction: give a coefficient, or use MoreauJean");
      if (law.static_friction > law.friction)
        bullet_stepper::refuse(*contact, "has a static coefficient of friction above the kinetic one",
                               "Bullet knows one coefficient: leave static_coefficient out, or use MoreauJean");
      for (const Collider& collider : contact->colliders()) add(*contact, contacts, collider);
      ++contacts;
    }
  }

  void add(const Contact& contact, int contact_index, const Collider& collider) {
    const int i = index_.at(collider.marker.body);
    std::vector<bullet_stepper::Geometry::Piece> pieces;
    geometry_.add(contact, collider.shape, pose_of(collider.marker), pieces);
    if (i < 0) {
      for (const auto& piece : pieces)
        add_body(0, {0, 0, 0}, piece.at, piece.shape, &contact, contact_index, &collider);
      return;
    }
    Mover& mover = movers_[i];
    const Element& body = *mover.of;
    if (mover.contact && mover.contact != &contact)
      bullet_stepper::refuse(body, "is in the contacts '" + mover.contact->name() + "' and '" + contact.name() + "'",
                             "Bullet knows one friction a body: put its colliders into one Contact");
    if (mover.collider && (mover.collider->group != collider.group || mover.collider->meets != collider.meets))
      bullet_stepper::refuse(body, "has colliders of several groups", "Bullet's stepper knows one group a body");
    if (std::any_of(pieces.begin(), pieces.end(), [](const auto& piece) { return !piece.convex; }))
      bullet_stepper::refuse(body, "moves with a half space or triangles",
                             "in Bullet only the ground can have those: give convex shapes, or use MoreauJean");
    mover.contact = &contact;
    mover.contact_index = contact_index;
    if (!mover.collider) mover.collider = &collider;
    mover.pieces.insert(mover.pieces.end(), pieces.begin(), pieces.end());
  }

  void add(Mover& mover, const VectorX& q, const VectorX& v) {
    const Matrix3 A = rotation_matrix(q.segment<4>(mover.q + 3));
    const Vector3 moments = (mover.axes.transpose() * mover.inertia.inertia * mover.axes).diagonal();
    mover.body = add_body(mover.inertia.mass, to_bullet(moments),
                          to_bullet(Vector3(q.segment<3>(mover.q)), Matrix3(A * mover.axes)),
                          geometry_.join(mover.pieces), mover.contact, mover.contact_index, mover.collider);
    mover.body->setLinearVelocity(to_bullet(Vector3(v.segment<3>(mover.v))));
    mover.body->setAngularVelocity(to_bullet(Vector3(A * v.segment<3>(mover.v + 3))));
    mover.body->setActivationState(DISABLE_DEACTIVATION);
  }

  btRigidBody* add_body(double mass, const btVector3& moments, const btTransform& pose, btCollisionShape* shape,
                        const Contact* contact, int contact_index, const Collider* collider) {
    btRigidBody::btRigidBodyConstructionInfo info(mass, nullptr, shape, moments);
    info.m_startWorldTransform = pose;
    if (contact) {
      // A pair has the product of two coefficients of friction and of restitution, and of rolling r_A μ_B + r_B μ_A.
      const RigidContact law = contact->rigid();
      info.m_friction = std::sqrt(law.friction);
      info.m_restitution = std::sqrt(law.restitution);
      if (law.friction > 0) {
        info.m_rollingFriction = law.rolling / (2 * info.m_friction);
        info.m_spinningFriction = law.spinning / (2 * info.m_friction);
      }
    }
    bodies_.push_back(std::make_unique<btRigidBody>(info));
    btRigidBody* body = bodies_.back().get();
    body->setUserIndex(contact_index);
    world_->addRigidBody(body, collider ? static_cast<int>(1u << collider->group) : 0,
                         collider ? static_cast<int>(collider->meets) : 0);
    return body;
  }

  void add(const Constraint& joint, const std::vector<Marker>& markers) {
    std::vector<btRigidBody*> body;
    std::vector<btTransform> at;
    for (const Marker& marker : markers) {
      const int i = index_.at(marker.body);
      body.push_back(i < 0 ? &ground_ : movers_[i].body);
      at.push_back(pose_of(marker));
    }
    std::unique_ptr<btTypedConstraint> made;
    if (dynamic_cast<const SphericalJoint*>(&joint)) {
      made = std::make_unique<btPoint2PointConstraint>(*body[0], *body[1], at[0].getOrigin(), at[1].getOrigin());
    } else if (dynamic_cast<const RevoluteJoint*>(&joint)) {
      made = std::make_unique<btHingeConstraint>(*body[0], *body[1], at[0], at[1]);
    } else if (dynamic_cast<const FixedJoint*>(&joint)) {
      made = std::make_unique<btFixedConstraint>(*body[0], *body[1], at[0], at[1]);
    } else if (dynamic_cast<const PrismaticJoint*>(&joint)) {
      // Bullet's slides along x.
      for (btTransform& pose : at) pose.getBasis() *= btMatrix3x3(0, 1, 0, 0, 0, 1, 1, 0, 0);
      made = std::make_unique<btSliderConstraint>(*body[0], *body[1], at[0], at[1], true);
    } else {
      bullet_stepper::refuse(joint, "is a joint that Bullet's stepper does not support",
                             "it supports spherical, revolute, fixed and prismatic ones: use MoreauJean");
    }
    joints_.push_back(std::move(made));
    world_->addConstraint(joints_.back().get());
  }

  bullet_stepper::Geometry geometry_;
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btDbvtBroadphase broadphase_;
  bullet_stepper::Filter filter_;
  std::unique_ptr<btMLCPSolverInterface> lcp_;
  std::unique_ptr<btConstraintSolver> solver_;
  std::unique_ptr<btDiscreteDynamicsWorld> world_;
  btEmptyShape nothing_;
  btRigidBody ground_{0, nullptr, &nothing_};
  std::vector<Mover> movers_;
  std::map<const Body*, int> index_;  // into movers_; -1: ground
  std::vector<std::unique_ptr<btRigidBody>> bodies_;
  std::vector<std::unique_ptr<btTypedConstraint>> joints_;
};

BulletStepper::BulletStepper(const System& system, Parameters parameters) : system_(system), parameters_(parameters) {
  require::at("BulletStepper", [&] {
    require::positive(parameters.step, "step");
    require::not_negative(parameters.margin, "margin");
    require::not_negative(parameters.restitution_threshold, "restitution_threshold");
    require::positive(parameters.iterations, "iterations");
  });
  world_ = std::make_unique<World>(system, parameters, system.initial_state().q, system.initial_state().v);
}

BulletStepper::~BulletStepper() = default;

std::string BulletStepper::name() const {
  switch (parameters_.solver) {
    case Solver::dantzig:
      return "Bullet, Dantzig";
    case Solver::lemke:
      return "Bullet, Lemke";
    case Solver::nncg:
      return "Bullet, NNCG, " + std::to_string(parameters_.iterations) + " iterations";
    default:
      return "Bullet, " + std::to_string(parameters_.iterations) + " iterations";
  }
}

void BulletStepper::prepare(EquationsOfMotion& equations, State& state) {
  if (&equations.layout() != &system_.layout())
    throw SceneError("these are the equations of another system", "BulletStepper",
                     "make a BulletStepper of the system that it is to move");
  // A new world: contacts and impulses of the last run must not act in this one.
  world_ = std::make_unique<World>(system_, parameters_, state.q, state.v);
  statistics_ = {};
  state.v_dot.setZero(equations.layout().v_count());
  state.lambda.setZero(equations.layout().row_count());
  Projector(equations).accelerations(state.time, state.q, state.v, state.v_dot, state.lambda);
}

StepResult BulletStepper::advance(EquationsOfMotion& equations, State& state, double t_stop) {
  if (!(t_stop > state.time)) return {};
  // Equal steps up to t_stop, no longer than the given one.
  const double left = t_stop - state.time, count = std::max(1.0, std::ceil(left / parameters_.step - 1e-6));
  const double h = std::abs(count * parameters_.step - left) > 1e-9 * left ? left / count : parameters_.step;

  q_ = state.q;
  v_.resize(state.v.size());
  world_->step(h);
  ++statistics_.steps;
  world_->read(q_, v_);
  if (!q_.allFinite() || !v_.allFinite()) {
    const auto broken = std::find_if(v_.data(), v_.data() + v_.size(), [](double x) { return !std::isfinite(x); });
    const int index = static_cast<int>(broken - v_.data());
    return {StepResult::Outcome::failed,
            "Bullet gives no finite values at the step of " + step_text(h) +
                (index < v_.size() ? "; first in " + system_.layout().velocity_name(index) : "")};
  }
  state.time = count == 1 ? t_stop : state.time + h;
  state.v_dot = (v_ - state.v) / h;
  state.q = q_;
  state.v = v_;
  state.lambda.resize(0);
  if (state.quarter_turns.size() > 0) equations.evaluate(state.time, state.q, state.v, Level::position);
  return {};
}

}  // namespace lithe
