#include <BulletDynamics/MLCPSolvers/btDantzigSolver.h>
#include <BulletDynamics/MLCPSolvers/btMLCPSolver.h>
#include <btBulletDynamicsCommon.h>

#include <cmath>

#include "tools/contact/piles.h"

namespace lithe::contact_bench {
namespace {

static_assert(sizeof(btScalar) == sizeof(double), "link bullet-float64");

btVector3 vector(const Vector3& x) { return {x[0], x[1], x[2]}; }
Vector3 vector(const btVector3& x) { return {x.x(), x.y(), x.z()}; }

class PlainBullet final : public Stepper {
 public:
  PlainBullet(const Pile& pile, double step, int sweeps, bool direct) : step_(step) {
    if (direct)
      solver_ = std::make_unique<btMLCPSolver>(&dantzig_);
    else
      solver_ = std::make_unique<btSequentialImpulseConstraintSolver>();
    world_ = std::make_unique<btDiscreteDynamicsWorld>(&dispatcher_, &broadphase_, solver_.get(), &configuration_);
    world_->setGravity(btVector3(0, 0, -kGravity));
    world_->getSolverInfo().m_numIterations = sweeps;
    if (direct) world_->getSolverInfo().m_minimumSolverBatchSize = 1;

    if (pile.cubes)
      shape_ = std::make_unique<btBoxShape>(btVector3(1, 1, 1) * (kCube / 2));
    else
      shape_ = std::make_unique<btSphereShape>(kRadius);
    add_plane(btVector3(0, 0, 1), 0);
    if (!pile.cubes)
      for (const double side : {-1.0, 1.0}) {
        add_plane(btVector3(-side, 0, 0), -pile.wall);
        add_plane(btVector3(0, -side, 0), -pile.wall);
      }
    for (std::size_t i = 0; i < pile.start.size(); ++i) {
      const double inertia = pile.inertia(i);
      btRigidBody::btRigidBodyConstructionInfo info(pile.mass[i], nullptr, shape_.get(), {inertia, inertia, inertia});
      info.m_startWorldTransform = btTransform(btQuaternion::getIdentity(), vector(pile.start[i]));
      info.m_friction = std::sqrt(kFriction);  // Bullet multiplies the two
      moving_.push_back(std::make_unique<btRigidBody>(info));
      moving_.back()->setActivationState(DISABLE_DEACTIVATION);
      world_->addRigidBody(moving_.back().get());
    }
  }
  ~PlainBullet() override {
    for (const auto* bodies : {&moving_, &fixed_})
      for (const auto& body : *bodies) world_->removeRigidBody(body.get());
  }
  void step() override { world_->stepSimulation(step_, 0); }
  void read(Motions& motions) const override {
    motions.clear();
    for (const auto& body : moving_) {
      const btMatrix3x3& R = body->getWorldTransform().getBasis();
      Matrix3 axes;
      for (int i = 0; i < 3; ++i) axes.row(i) = vector(R.getRow(i));
      motions.push_back({vector(body->getCenterOfMassPosition()), vector(body->getLinearVelocity()),
                         vector(body->getAngularVelocity()), axes});
    }
  }

 private:
  void add_plane(const btVector3& normal, double offset) {
    planes_.push_back(std::make_unique<btStaticPlaneShape>(normal, offset));
    btRigidBody::btRigidBodyConstructionInfo info(0, nullptr, planes_.back().get());
    info.m_friction = std::sqrt(kFriction);
    fixed_.push_back(std::make_unique<btRigidBody>(info));
    world_->addRigidBody(fixed_.back().get());
  }

  double step_;
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btDbvtBroadphase broadphase_;
  btDantzigSolver dantzig_;
  std::unique_ptr<btConstraintSolver> solver_;
  std::unique_ptr<btDiscreteDynamicsWorld> world_;
  std::unique_ptr<btCollisionShape> shape_;
  std::vector<std::unique_ptr<btStaticPlaneShape>> planes_;
  std::vector<std::unique_ptr<btRigidBody>> fixed_, moving_;
};

}  // namespace

std::unique_ptr<Stepper> plain_bullet(const Pile& pile, double step, int sweeps, bool direct) {
  return std::make_unique<PlainBullet>(pile, step, sweeps, direct);
}

}  // namespace lithe::contact_bench
