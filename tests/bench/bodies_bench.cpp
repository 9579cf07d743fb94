// Boxes at rest, afloat and stacked: this project beside Bullet, ODE and Box2D. The same sizes, masses, friction, rate and numbers of
// iterations; interleaved in one run, the least of the repetitions.
//
//   bodies_bench [REPETITIONS]
//
// Box2D is two-dimensional and made for bodies of about a metre: its lengths, and gravity with them, are 33 times as large.
#include <box2d/box2d.h>
#include <btBulletDynamicsCommon.h>
#include <ode/ode.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "control/renderer.h"
#include "host-tools/compiler/compile.h"
#include "tests/bench/box_layouts.h"
#include "tests/support/scene.h"

namespace thimble::test {
namespace {

constexpr float kPeriod_s = 1.0F / 4000.0F;
constexpr int kIterations = 10;
constexpr int kSecondIterations = 4;  // of positions, or with rigid contacts

class Peer {
 public:
  virtual ~Peer() = default;
  virtual void step() = 0;
  [[nodiscard]] virtual Eigen::Vector3f position_m(std::size_t body) const = 0;
};

class Ours : public Peer {
 public:
  explicit Ours(const Layout& layout) {
    image_ = std::make_unique<SceneImage>(
        host::compile_scene_text(box_scene(layout), "bench.scene.json", ".").image);
    renderer_.bind(image_->view());
  }
  void step() override { renderer_.tick({}, kPeriod_s, {}); }
  [[nodiscard]] Eigen::Vector3f position_m(std::size_t body) const override {
    return renderer_.bodies()[body].position_m;
  }

 private:
  std::unique_ptr<SceneImage> image_;
  control::Renderer renderer_;
};

class Bullet : public Peer {
 public:
  Bullet(const Layout& layout, bool sleeps) {
    world_.setGravity(btVector3(0, 0, layout.gravity ? -9.81F : 0));
    world_.getSolverInfo().m_numIterations = kIterations + kSecondIterations;
    floor_.setMargin(0);
    box_.setMargin(.001F);
    add(floor_, 0, Eigen::Vector3f::Zero(), sleeps);
    for (const Eigen::Vector3f& at : layout.at_m) add(box_, kMass_kg, at, sleeps);
  }
  ~Bullet() override {
    for (const auto& body : bodies_) world_.removeRigidBody(body.get());
  }
  Bullet(const Bullet&) = delete;
  Bullet& operator=(const Bullet&) = delete;
  void step() override { world_.stepSimulation(kPeriod_s, 0); }
  [[nodiscard]] Eigen::Vector3f position_m(std::size_t body) const override {
    const btVector3& p = bodies_[body + 1]->getWorldTransform().getOrigin();
    return {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())};
  }

 private:
  void add(btCollisionShape& shape, float mass, const Eigen::Vector3f& at, bool sleeps) {
    btVector3 inertia(0, 0, 0);
    if (mass > 0) shape.calculateLocalInertia(mass, inertia);
    btRigidBody::btRigidBodyConstructionInfo info(mass, nullptr, &shape, inertia);
    info.m_friction = std::sqrt(kFriction);  // Bullet takes the product of both
    info.m_startWorldTransform.setOrigin(btVector3(at.x(), at.y(), at.z()));
    bodies_.push_back(std::make_unique<btRigidBody>(info));
    if (!sleeps) bodies_.back()->setActivationState(DISABLE_DEACTIVATION);
    world_.addRigidBody(bodies_.back().get());
  }

  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btDbvtBroadphase broadphase_;
  btSequentialImpulseConstraintSolver solver_;
  btDiscreteDynamicsWorld world_{&dispatcher_, &broadphase_, &solver_, &configuration_};
  btStaticPlaneShape floor_{btVector3(0, 0, 1), 0};
  btBoxShape box_{btVector3(kSide_m / 2, kSide_m / 2, kSide_m / 2)};
  std::vector<std::unique_ptr<btRigidBody>> bodies_;
};

class Ode : public Peer {
 public:
  Ode(const Layout& layout, bool sleeps)
      : world_(dWorldCreate()), space_(dHashSpaceCreate(nullptr)), joints_(dJointGroupCreate(0)) {
    dWorldSetGravity(world_, 0, 0, layout.gravity ? -9.81 : 0);
    dWorldSetQuickStepNumIterations(world_, kIterations + kSecondIterations);
    dWorldSetAutoDisableFlag(world_, sleeps ? 1 : 0);
    if (layout.gravity) dCreatePlane(space_, 0, 0, 1, 0);
    for (const Eigen::Vector3f& at : layout.at_m) {
      bodies_.push_back(dBodyCreate(world_));
      dMass mass;
      dMassSetBoxTotal(&mass, kMass_kg, kSide_m, kSide_m, kSide_m);
      dBodySetMass(bodies_.back(), &mass);
      dBodySetPosition(bodies_.back(), at.x(), at.y(), at.z());
      dGeomSetBody(dCreateBox(space_, kSide_m, kSide_m, kSide_m), bodies_.back());
    }
  }
  ~Ode() override {
    dJointGroupDestroy(joints_);
    dSpaceDestroy(space_);
    dWorldDestroy(world_);
  }
  Ode(const Ode&) = delete;
  Ode& operator=(const Ode&) = delete;
  void step() override {
    dSpaceCollide(space_, this, &Ode::near);
    dWorldQuickStep(world_, kPeriod_s);
    dJointGroupEmpty(joints_);
  }
  [[nodiscard]] Eigen::Vector3f position_m(std::size_t body) const override {
    const dReal* p = dBodyGetPosition(bodies_[body]);
    return {static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])};
  }

 private:
  static void near(void* self, dGeomID a, dGeomID b) {
    auto& ode = *static_cast<Ode*>(self);
    const dBodyID body_a = dGeomGetBody(a);
    const dBodyID body_b = dGeomGetBody(b);
    const bool awake = (body_a != nullptr && dBodyIsEnabled(body_a) != 0) ||
                       (body_b != nullptr && dBodyIsEnabled(body_b) != 0);
    if (!awake) return;
    std::array<dContact, 8> contacts;
    const int count = dCollide(a, b, static_cast<int>(contacts.size()), &contacts[0].geom, sizeof(dContact));
    for (int i = 0; i < count; ++i) {
      dContact& contact = contacts.at(static_cast<std::size_t>(i));
      contact.surface.mode = dContactApprox1;
      contact.surface.mu = kFriction;
      dJointAttach(dJointCreateContact(ode.world_, ode.joints_, &contact), body_a, body_b);
    }
  }

  dWorldID world_;
  dSpaceID space_;
  dJointGroupID joints_;
  std::vector<dBodyID> bodies_;
};

class Box2d : public Peer {
 public:
  Box2d(const Layout& layout, bool sleeps) : world_(b2Vec2(0, layout.gravity ? -9.81F * kScale : 0)) {
    world_.SetAllowSleeping(sleeps);
    if (layout.gravity) {
      b2BodyDef floor;
      b2EdgeShape edge;
      edge.SetTwoSided(b2Vec2(-100, 0), b2Vec2(100, 0));
      b2FixtureDef fixture;
      fixture.shape = &edge;
      fixture.friction = kFriction;
      world_.CreateBody(&floor)->CreateFixture(&fixture);
    }
    for (const Eigen::Vector3f& at : layout.at_m) {
      b2BodyDef body;
      body.type = b2_dynamicBody;
      body.position.Set(kScale * at.x(), kScale * at.z());
      bodies_.push_back(world_.CreateBody(&body));
      b2PolygonShape box;
      box.SetAsBox(kScale * kSide_m / 2, kScale * kSide_m / 2);
      b2FixtureDef fixture;
      fixture.shape = &box;
      fixture.friction = kFriction;
      fixture.density = kMass_kg / (kScale * kSide_m * kScale * kSide_m);
      bodies_.back()->CreateFixture(&fixture);
    }
  }
  void step() override { world_.Step(kPeriod_s, kIterations, kSecondIterations); }
  [[nodiscard]] Eigen::Vector3f position_m(std::size_t body) const override {
    const b2Vec2& p = bodies_[body]->GetPosition();
    return {p.x / kScale, 0, p.y / kScale};
  }

 private:
  static constexpr float kScale = 1.0F / kSide_m;
  b2World world_;
  std::vector<b2Body*> bodies_;
};

double drift_m(const Peer& peer, const std::vector<Eigen::Vector3f>& from) {
  double most = 0;
  for (std::size_t i = 0; i < from.size(); ++i)
    most = std::max(most, static_cast<double>((peer.position_m(i) - from[i]).norm()));
  return most;
}

std::vector<Eigen::Vector3f> places(const Peer& peer, std::size_t count) {
  std::vector<Eigen::Vector3f> at;
  for (std::size_t i = 0; i < count; ++i) at.push_back(peer.position_m(i));
  return at;
}

double step_us(Peer& peer, int steps) {
  const auto begin = std::chrono::steady_clock::now();
  for (int i = 0; i < steps; ++i) peer.step();
  return std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - begin).count() / steps;
}

using Make = std::function<std::unique_ptr<Peer>(const Layout&)>;
struct Row {
  std::string name;
  Make make;
  int settles;  // steps before the time is taken; ours sleeps after 0.25 s, so what is awake is measured before
};

void run(int repetitions) {
  constexpr int kAwake = 400;
  constexpr int kAsleep = 12000;
  const std::vector<Row> rows = {
      {"thimble, awake", [](const Layout& l) { return std::make_unique<Ours>(l); }, kAwake},
      {"thimble, asleep", [](const Layout& l) { return std::make_unique<Ours>(l); }, kAsleep},
      {"Bullet, no sleep", [](const Layout& l) { return std::make_unique<Bullet>(l, false); }, kAwake},
      {"Bullet, sleep", [](const Layout& l) { return std::make_unique<Bullet>(l, true); }, kAsleep},
      {"ODE, no sleep", [](const Layout& l) { return std::make_unique<Ode>(l, false); }, kAwake},
      {"ODE, sleep", [](const Layout& l) { return std::make_unique<Ode>(l, true); }, kAsleep},
      {"Box2D, no sleep", [](const Layout& l) { return std::make_unique<Box2d>(l, false); }, kAwake},
      {"Box2D, sleep", [](const Layout& l) { return std::make_unique<Box2d>(l, true); }, kAsleep}};
  for (const Layout& layout : box_layouts()) {
    std::vector<double> least_us(rows.size(), std::numeric_limits<double>::infinity());
    std::vector<double> moved_m(rows.size(), 0);
    for (int repetition = 0; repetition < repetitions; ++repetition) {
      for (std::size_t i = 0; i < rows.size(); ++i) {
        const std::unique_ptr<Peer> peer = rows[i].make(layout);
        for (int step = 0; step < rows[i].settles; ++step) peer->step();
        least_us[i] = std::min(least_us[i], step_us(*peer, 400));
        if (repetition > 0) continue;
        const std::vector<Eigen::Vector3f> from = places(*peer, layout.at_m.size());
        for (int step = 0; step < 80000; ++step) peer->step();
        moved_m[i] = drift_m(*peer, from);
      }
    }
    for (std::size_t i = 0; i < rows.size(); ++i)
      std::printf("%-12s %-18s %8.2f us a step, %12.2f um moved in 20 s\n", layout.name.c_str(),
                  rows[i].name.c_str(), least_us[i], 1e6 * moved_m[i]);
  }
}

}  // namespace
}  // namespace thimble::test

int main(int argc, char** argv) {
  dInitODE2(0);
  thimble::test::run(argc > 1 ? std::atoi(argv[1]) : 5);
  dCloseODE();
}
