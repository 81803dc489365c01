// Closed loops in MuJoCo, by rk4: joint coordinates along a tree, `connect` constraints where it closes. They are soft:
// a gap r is driven back by -k r - b ṙ, and a row keeps at least 1e-4 of the acceleration it would have without its
// constraint, so that the loops stay open by some 1e-4 |a| / k. That is the whole error: k = (2/h)² and b = 2/h are
// close to the most that rk4 bears.
#include <algorithm>

#include "tools/bench/peers/mechanisms.h"
#include "tools/bench/peers/mujoco.h"

namespace lithe::bench::peers {

namespace {

/// XML with numbers to their last digit.
class Xml {
 public:
  Xml() { text_.precision(17); }
  template <class Word>
  Xml& operator<<(const Word& word) {
    text_ << word;
    return *this;
  }
  Xml& operator<<(const Point& p) {
    text_ << p[0] << ' ' << p[1] << ' ' << p[2];
    return *this;
  }
  std::string text() const { return text_.str(); }

 private:
  std::ostringstream text_;
};

/// Opens a body on a hinge at its origin, turned by `angle` about it as drawn; to be closed by </body>.
std::string body(const std::string& name, const Point& at, const Point& axis, double mass, const Point& center,
                 const Point& moments, double angle = 0) {
  Xml xml;
  xml << "<body name='" << name << "' pos='" << at << "' axisangle='" << axis << ' ' << angle
      << "'><joint type='hinge' axis='" << axis << "'/><inertial pos='" << center << "' mass='" << mass
      << "' diaginertia='" << moments << "'/>";
  return xml.text();
}

/// A point of body A stays at the point of B (nothing: the ground) where it is drawn.
std::string connect(const Request& request, const std::string& a, const Point& on_a, const std::string& b) {
  const double rate = 2 / request.step;
  Xml xml;
  xml << "<connect body1='" << a << "'" << (b.empty() ? "" : " body2='" + b + "'") << " anchor='" << on_a
      << "' solref='" << -rate * rate << ' ' << -rate << "' solimp='0.9999 0.9999 0.001 0.5 2'/>";
  return xml.text();
}

MujocoModel load(const Request& request, const Point& gravity, const std::string& bodies, const std::string& closures,
                 const std::string& rest = "") {
  Xml g;
  g << gravity;
  return load_mujoco({{"world.xml", "<mujoco>" + mujoco_options(request, g.text(), true) + "<worldbody>" + bodies +
                                        "</worldbody><equality>" + closures + "</equality>" + rest + "</mujoco>"}});
}

double energy(mjModel* model, mjData* data) {
  model->opt.enableflags |= mjENBL_ENERGY;
  mj_forward(model, data);
  model->opt.enableflags &= ~mjENBL_ENERGY;
  return data->energy[0] + data->energy[1];
}

Outcome run_andrews(const Request& request) {
  using namespace andrews;
  const Point z{0, 0, 1};
  const auto planar = [&](int k, double x, double y, const Point& center) {
    const double I = kInertia[k];
    return body("K" + std::to_string(k + 1), {x, y, 0}, z, kMass[k], center, {I, I, I}, kStart[k]);
  };
  Xml bodies;
  bodies << planar(0, 0, 0, {ra, 0, 0}) << planar(1, rr, 0, {-da, 0, 0}) << "</body></body>"
         << planar(2, kB[0], kB[1], {sa, sb, 0}) << "<site name='D' pos='" << Point{sd, -sc, 0} << "'/></body>"
         << planar(4, kA[0], kA[1], {ta, tb, 0}) << planar(3, zt, 0, {0, -(e - ea), 0}) << "</body></body>"
         << planar(6, kA[0], kA[1], {ua, ub, 0}) << planar(5, 0, -u, {zf - fa, 0, 0}) << "</body></body>"
         << "<site name='C' pos='" << Point{kC[0], kC[1], 0} << "'/>";
  Xml spring;
  spring << "<tendon><spatial stiffness='" << kStiffness << "' springlength='" << kRestLength
         << "'><site site='D'/><site site='C'/></spatial></tendon>";
  const Point E{-d, 0, 0};
  const MujocoModel model =
      load(request, {0, 0, 0}, bodies.text(),
           connect(request, "K2", E, "K3") + connect(request, "K2", E, "K4") + connect(request, "K2", E, "K6"),
           spring.text());
  const MujocoData data(mj_makeData(model.get()));
  data->qfrc_applied[0] = kTorque;
  const double start = energy(model.get(), data.get());

  Outcome outcome;
  outcome.steps = request.steps;
  const double started = cpu_seconds();
  step_mujoco(model.get(), data.get(), request.steps);
  outcome.seconds = cpu_seconds() - started;
  constexpr int kOrder[7] = {0, 1, 2, 4, 3, 6, 5};  // of the bodies above
  std::array<double, 7> reached{};
  for (int i = 0; i < 7; ++i) reached[kOrder[i]] = kStart[kOrder[i]] + data->qpos[i];
  outcome.error = worst_angle(reached);
  outcome.energy_error = std::abs(energy(model.get(), data.get()) - start - kTorque * data->qpos[0]);
  return outcome;
}

/// The origin of body `id` on its path.
Outcome follow_body(const Request& request, const Path& path, mjModel* model, mjData* data, int id) {
  return follow(
      request, path, [&](long count) { step_mujoco(model, data, count); },
      [&] {
        const mjtNum* p = data->xpos + 3 * id;  // where energy() has just put it
        return Point{p[0], p[1], p[2]};
      },
      [&] { return energy(model, data); });
}

Outcome run_four_bar(const Request& request) {
  const Point y{0, 1, 0}, up{0, 0, kRodLength}, along{kRodLength, 0, 0};
  const auto name = [](const char* kind, int i) { return kind + std::to_string(i); };
  const int n = request.count;
  Xml bodies, closures;
  for (int i = 0; i <= n; ++i) {
    bodies << body(name("upright", i), i * along, y, kRodMass, 0.5 * up, {kAcross, kAcross, kAcross});
    if (i < n) {
      bodies << body(name("coupler", i), up, y, kRodMass, 0.5 * along, {kAcross, kAcross, kAcross}) << "</body>";
      closures << connect(request, name("coupler", i), along, name("upright", i + 1));
    }
    bodies << "</body>";
  }
  const MujocoModel model = load(request, {0, 0, -kGravity}, bodies.text(), closures.text());
  const MujocoData data(mj_makeData(model.get()));
  for (int i = 0; i < model->nv; ++i) data->qvel[i] = (i % 2 == 0 ? 1 : -1) * four_bar::kSpeed / kRodLength;
  return follow_body(request, four_bar::first_top(n, request.end), model.get(), data.get(), 2);  // the first coupler
}

Outcome run_bricard(const Request& request) {
  using bricard::kPoints;
  const auto at = [](int i) { return Point{kPoints[i][0], kPoints[i][1], kPoints[i][2]}; };
  const Point x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1}, axes[5] = {y, z, x, y, z};
  Xml bodies;
  for (int i = 0; i < 5; ++i) {
    const Point rod = at(i + 1) - at(i);
    Point moments{bricard::kAcross, bricard::kAcross, bricard::kAcross};
    for (int k = 0; k < 3; ++k)
      if (rod[k] != 0) moments[k] = bricard::kAlong;
    bodies << body("rod" + std::to_string(i), i > 0 ? at(i) - at(i - 1) : at(0), axes[i], kRodMass, 0.5 * rod, moments);
  }
  for (int i = 0; i < 5; ++i) bodies << "</body>";
  // The last revolute: two points of its axis.
  const Point last = at(5) - at(4);
  const MujocoModel model = load(request, {0, -kGravity, 0}, bodies.text(),
                                 connect(request, "rod4", last, "") + connect(request, "rod4", last + x, ""));
  const MujocoData data(mj_makeData(model.get()));
  return follow_body(request, Path(request.reference()), model.get(), data.get(), 3);
}

}  // namespace

Outcome run_mujoco_loop(const Request& request) {
  if (request.method != "rk4") throw std::invalid_argument("MuJoCo's loops are as stiff as rk4 bears: no other method");
  Outcome outcome = request.problem == "andrews"    ? run_andrews(request)
                    : request.problem == "four_bar" ? run_four_bar(request)
                                                    : run_bricard(request);
  outcome.note = "soft closures, their stiffness as the step allows";
  return outcome;
}

}  // namespace lithe::bench::peers
