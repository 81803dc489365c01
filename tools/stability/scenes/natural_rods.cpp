#include "tools/stability/scenes/natural_rods.h"

#include "engine/assembly/batch_of.h"
#include "joints/distance_joint.h"

namespace lithe {
template std::unique_ptr<BodyBatch> make_body_batch<lab::NaturalRods>();
}

namespace lithe::lab {
namespace {

constexpr double kGravity = 9.81;  // m/s²

}  // namespace

NaturalRods::NaturalRods(Parameters parameters) : parameters_(parameters), count_(2 * (parameters.windows + 1)) {
  const int joints = parameters.windows + 1;
  set_marker_count(joints);
  const double m = parameters.mass;
  mass_ = m / 3 * MatrixX::Identity(count_, count_);  // uprights
  weight_ = VectorX::Constant(joints, m / 2);
  for (int i = 0; i < parameters.windows; ++i) {  // couplers
    for (const int k : {2 * i, 2 * i + 1}) {
      mass_(k, k) += m / 3, mass_(k + 2, k + 2) += m / 3;
      mass_(k, k + 2) += m / 6, mass_(k + 2, k) += m / 6;
    }
    weight_[i] += m / 2, weight_[i + 1] += m / 2;
  }
  std::vector<int> rows, columns;
  for (int k = 0; k < count_; ++k)
    for (const int row : {k, k + 2})
      if (row < count_) rows.push_back(row), columns.push_back(k);
  pattern_.rows = Eigen::Map<Eigen::VectorXi>(rows.data(), static_cast<int>(rows.size()));
  pattern_.columns = Eigen::Map<Eigen::VectorXi>(columns.data(), static_cast<int>(columns.size()));
  for (int i = 0; i < joints; ++i) {
    shapes_.push_back(MatrixX::Zero(6, count_));
    shapes_[i](0, 2 * i) = shapes_[i](1, 2 * i + 1) = 1;
  }
}

void NaturalRods::initial_state(VectorRef q, VectorRef v) const {
  const double L = parameters_.length, s = std::sin(parameters_.angle), c = std::cos(parameters_.angle);
  for (int i = 0; i <= parameters_.windows; ++i) {
    q.segment<2>(2 * i) << L * (i + s), L * c;
    v.segment<2>(2 * i) << parameters_.speed * c, -parameters_.speed * s;
  }
}

void NaturalRods::add_residual(const BodyState&, const double* v_dot, const Vector3& gravity, double* r) const {
  Eigen::Map<VectorX> out(r, count_);
  out += mass_ * Eigen::Map<const VectorX>(v_dot, count_);
  for (int i = 0; i < count_ / 2; ++i) out.segment<2>(2 * i) -= weight_[i] * gravity.head<2>();
}

void NaturalRods::add_tangent(const BodyState&, const double*, const Vector3&, const TangentWeights& weights,
                              BodyTangent& tangent) const {
  for (int k = 0; k < pattern_.rows.size(); ++k)
    tangent.linear[k] += weights.acceleration * mass_(pattern_.rows[k], pattern_.columns[k]);
}

void NaturalRods::marker_kinematics(const BodyState& state, int marker, Level, MarkerKinematics& k) const {
  k.p = k.r = Vector3(state.q[2 * marker], state.q[2 * marker + 1], 0);
  k.v = Vector3(state.v[2 * marker], state.v[2 * marker + 1], 0);
  k.R = Matrix3::Identity();
  k.w = k.bias_v = k.bias_w = Vector3::Zero();
  k.A = &state.cache->A;
  k.elastic = shapes_[marker].data();
}

BodyEnergy NaturalRods::energy(const BodyState& state, const Vector3& gravity) const {
  const Eigen::Map<const VectorX> q(state.q, count_), v(state.v, count_);
  BodyEnergy energy;
  energy.kinetic = 0.5 * v.dot(mass_ * v);
  for (int i = 0; i < count_ / 2; ++i) energy.gravity -= weight_[i] * gravity.head<2>().dot(q.segment<2>(2 * i));
  return energy;
}

Windows::Windows(const NaturalRods::Parameters& parameters)
    : Bench({0, -kGravity, 0},
            [&](SystemGraph& graph) {
              auto& rods = graph.add<NaturalRods>("rods", parameters);
              const double L = parameters.length;
              for (int i = 0; i <= parameters.windows; ++i) {
                const std::string number = std::to_string(i);
                graph.add<DistanceJoint>("upright " + number, {graph.ground().marker({i * L, 0, 0}), rods.joint(i)},
                                         {.length = L});
                if (i > 0)
                  graph.add<DistanceJoint>("coupler " + number, {rods.joint(i - 1), rods.joint(i)}, {.length = L});
              }
            }),
      parameters_(parameters) {}

double Windows::angle(int upright) const {
  return std::atan2(state.q[2 * upright] - upright * parameters_.length, state.q[2 * upright + 1]);
}

double Windows::mismatch() const {
  double largest = 0;
  for (int i = 1; i <= parameters_.windows; ++i)
    largest = std::max(largest, std::abs(std::remainder(angle(i) - angle(0), 2 * M_PI)));
  return largest;
}

double parallelogram_stiffness(const NaturalRods::Parameters& p) {
  return kGravity / p.length * ((p.windows + 1) / 2.0 + p.windows) / ((p.windows + 1) / 3.0 + p.windows);
}

double parallelogram_angle(const NaturalRods::Parameters& p, double time) {
  const double kappa = parallelogram_stiffness(p);
  const int count = std::max(1, static_cast<int>(std::ceil(time / 1e-4)));
  const double h = time / count;
  double th = p.angle, w = p.speed / p.length;
  const auto a = [&](double angle) { return kappa * std::sin(angle); };
  for (int i = 0; i < count; ++i) {
    const double a1 = a(th), w2 = w + h / 2 * a1, a2 = a(th + h / 2 * w), w3 = w + h / 2 * a2, a3 = a(th + h / 2 * w2),
                 w4 = w + h * a3, a4 = a(th + h * w3);
    th += h / 6 * (w + 2 * w2 + 2 * w3 + w4);
    w += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
  }
  return th;
}

}  // namespace lithe::lab
