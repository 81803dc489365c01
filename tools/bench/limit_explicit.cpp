// limit_explicit: how fast can a computer find the accelerations of one scene? The chain of limit_chain.cpp, swinging
// in space: unit rods of 1 kg and 1 m with ball joints. Nothing here is general: Lithe's us_per_link_acceleration is
// measured beside it.
//
//   --n 1000  rods   --evaluations 2000  of all accelerations   --repeat 5  runs, the cheapest counts
//
// A rod's bodies are eliminated first: forces y of its two joints move its two ends by m⁻¹ (y_in - y_out) and, through
// its turning, by W (y_in + y_out) with W = k (E - a aᵀ), a the axis, k = (½ l)² / J. What remains are the joints'
// forces, 3x3 blocks tied to their neighbours alone: from the tip inwards, then outwards with the accelerations.
#include <Eigen/LU>
#include <random>
#include <vector>

#include "engine/base/math.h"
#include "tools/bench/measure.h"

namespace lithe::bench {
namespace {

constexpr double kMass = 1, kHalf = 0.5, kGravity = 9.81, kAlong = 1.25e-3, kAcross = 1.0 / 12;
constexpr double kMobility = 1 / kMass, kTurning = kHalf * kHalf / kAcross;  // 1/m and k

/// Attitude and angular velocity, which is in the rod's axes: the accelerations depend on nothing else.
struct Rod {
  Vector4 attitude;
  Vector3 spin;
};
struct Acceleration {
  Vector3 linear, angular;
};

struct Symmetric {
  double xx, yy, zz, xy, xz, yz;

  Vector3 operator*(const Vector3& v) const {
    return {xx * v[0] + xy * v[1] + xz * v[2], xy * v[0] + yy * v[1] + yz * v[2], xz * v[0] + yz * v[1] + zz * v[2]};
  }
  /// + s E + t a aᵀ
  void add(double s, double t, const Vector3& a) {
    const Vector3 b = t * a;
    xx += s + a[0] * b[0], yy += s + a[1] * b[1], zz += s + a[2] * b[2];
    xy += a[0] * b[1], xz += a[0] * b[2], yz += a[1] * b[2];
  }
  Symmetric inverse() const {
    const double x = yy * zz - yz * yz, y = xz * yz - xy * zz, z = xy * yz - xz * yy;
    const double s = 1 / (xx * x + xy * y + xz * z);
    return {s * x, s * (xx * zz - xz * xz), s * (xx * yy - xy * xy), s * y, s * z, s * (xy * xz - xx * yz)};
  }
};

/// U = W - m⁻¹ E, by which the forces of a rod's two joints are coupled.
constexpr double kShared = kTurning - kMobility;
Vector3 couple(const Vector3& a, const Vector3& y) { return kShared * y - (kTurning * a.dot(y)) * a; }

class SwingingChain {
 public:
  explicit SwingingChain(int count) : links_(count) {}

  void accelerations(const std::vector<Rod>& rods, std::vector<Acceleration>& result) {
    eliminate(rods);
    const std::size_t count = links_.size();
    Vector3 force = links_[0].compliance * links_[0].gap;  // of the joint at the rod's inboard end
    for (std::size_t i = 0; i < count; ++i) {
      const Link& link = links_[i];
      Vector3 outer = Vector3::Zero();
      if (i + 1 < count) outer = links_[i + 1].compliance * (links_[i + 1].gap - couple(link.A.col(0), force));
      const Vector3 sum = force + outer, &w = rods[i].spin;
      constexpr double gyroscopic = 1 - kAlong / kAcross, lever = kHalf / kAcross;
      result[i].linear = kMobility * (force - outer) - Vector3(0, 0, kGravity);
      result[i].angular = Vector3(0, gyroscopic * w[0] * w[2] + lever * link.A.col(2).dot(sum),
                                  -gyroscopic * w[0] * w[1] - lever * link.A.col(1).dot(sum));
      force = outer;
    }
  }

 private:
  struct Link {
    Matrix3 A;
    Symmetric compliance;  // inverse of the joint's diagonal block, after elimination of all outer joints
    Vector3 gap;           // acceleration that the joint has to undo; theirs included
  };

  void eliminate(const std::vector<Rod>& rods) {
    Symmetric diagonal{};  // what the rod outside has left of this joint's row
    Vector3 gap = Vector3::Zero();
    Vector3 swing = begin(rods.back(), links_.back());
    for (std::size_t i = links_.size(); i-- > 0;) {
      Link& link = links_[i];
      diagonal.add(kTurning + kMobility, -kTurning, link.A.col(0));
      gap += swing;
      if (i == 0) {
        gap[2] += kGravity;  // the ground does not fall
        link.gap = gap;
        link.compliance = diagonal.inverse();
        return;
      }
      Link& inner = links_[i - 1];
      swing = begin(rods[i - 1], inner);
      const Vector3 a = inner.A.col(0);
      diagonal.add(kTurning + kMobility, -kTurning, a);
      gap += swing;
      link.gap = gap;
      const Symmetric C = diagonal.inverse();
      link.compliance = C;
      // - U C U = - s² C + k s (a (C a)ᵀ + (C a) aᵀ) - k² (a·C a) a aᵀ,   U = s E - k a aᵀ
      const Vector3 c = C * a;
      const double square = -kShared * kShared;
      diagonal = {square * C.xx, square * C.yy, square * C.zz, square * C.xy, square * C.xz, square * C.yz};
      const Vector3 b = (kTurning * kShared) * c - (0.5 * kTurning * kTurning * a.dot(c)) * a;
      diagonal.xx += 2 * a[0] * b[0], diagonal.yy += 2 * a[1] * b[1], diagonal.zz += 2 * a[2] * b[2];
      diagonal.xy += a[0] * b[1] + a[1] * b[0];
      diagonal.xz += a[0] * b[2] + a[2] * b[0];
      diagonal.yz += a[1] * b[2] + a[2] * b[1];
      gap = -couple(a, C * gap);
    }
  }

  /// Attitude of a rod; returns the acceleration of its outboard end from its centre without forces of joints:
  /// ½ l A (ω̇ × e + ω × (ω × e)) with J ω̇ = -ω × J ω.
  static Vector3 begin(const Rod& rod, Link& link) {
    link.A = rotation_matrix(rod.attitude);
    const Vector3& w = rod.spin;
    constexpr double ratio = kAlong / kAcross;
    return kHalf * (link.A * Vector3(-w[1] * w[1] - w[2] * w[2], ratio * w[0] * w[1], ratio * w[0] * w[2]));
  }

  std::vector<Link> links_;
};

/// Any attitudes, any angular velocities.
std::vector<Rod> swinging_rods(int count) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> number(-1, 1);
  std::vector<Rod> rods(count);
  for (Rod& rod : rods) {
    for (double& q : rod.attitude) q = number(random);
    for (double& w : rod.spin) w = number(random);
    rod.attitude.normalize();
  }
  return rods;
}

/// Largest difference from the whole system of equations, M v̇ + Gᵀ λ = f and G v̇ = γ, solved at once.
double difference_from_dense(const std::vector<Rod>& rods, const std::vector<Acceleration>& found) {
  const int n = static_cast<int>(rods.size()), bodies = 6 * n;
  MatrixX K = MatrixX::Zero(9 * n, 9 * n);
  VectorX right = VectorX::Zero(9 * n);
  const Vector3 inertia(kAlong, kAcross, kAcross), end(kHalf, 0, 0);
  for (int i = 0; i < n; ++i) {
    const Matrix3 A = rotation_matrix(rods[i].attitude);
    const Vector3& w = rods[i].spin;
    K.block<3, 3>(6 * i, 6 * i).diagonal().setConstant(kMass);
    K.block<3, 3>(6 * i + 3, 6 * i + 3).diagonal() = inertia;
    right[6 * i + 2] = -kMass * kGravity;
    right.segment<3>(6 * i + 3) = -w.cross(Vector3(inertia.cwiseProduct(w)));
    const auto tie = [&](int joint, double side, const Vector3& arm) {  // side × acceleration of the point at `arm`
      const int row = bodies + 3 * joint;
      K.block<3, 3>(row, 6 * i) = side * Matrix3::Identity();
      K.block<3, 3>(row, 6 * i + 3) = -side * A * skew(arm);
      right.segment<3>(row) -= side * A * w.cross(w.cross(arm));
    };
    tie(i, 1, -end);
    if (i + 1 < n) tie(i + 1, -1, end);
  }
  K.topRightCorner(bodies, 3 * n) = K.bottomLeftCorner(3 * n, bodies).transpose();
  const VectorX solved = K.fullPivLu().solve(right);
  double worst = 0;
  for (int i = 0; i < n; ++i)
    worst = std::max({worst, (solved.segment<3>(6 * i) - found[i].linear).cwiseAbs().maxCoeff(),
                      (solved.segment<3>(6 * i + 3) - found[i].angular).cwiseAbs().maxCoeff()});
  return worst;
}

/// Throws std::runtime_error unless four rods move as they should.
void check() {
  std::vector<Rod> level(4, {Vector4(1, 0, 0, 0), Vector3::Zero()});
  for (const std::vector<Rod>& rods : {swinging_rods(4), level}) {
    std::vector<Acceleration> found(4);
    SwingingChain(4).accelerations(rods, found);
    const double difference = difference_from_dense(rods, found);
    if (!(difference < 1e-11))
      throw std::runtime_error("limit_explicit is " + std::to_string(difference) + " away from a dense solution");
  }
}

}  // namespace
}  // namespace lithe::bench

int main(int argument_count, char** words) {
  using namespace lithe::bench;
  return run_program(argument_count, words, [](Arguments& arguments) {
    const int count = arguments.integer("n", 1000), repeats = arguments.integer("repeat", 5);
    const long evaluations = arguments.integer("evaluations", 2000);
    arguments.finish();
    check();

    const std::vector<Rod> rods = swinging_rods(count);
    std::vector<Acceleration> found(count);
    SwingingChain chain(count);
    const Cost cost = least_of(repeats, [&] {
      Cost run{.steps = evaluations};
      const double started = cpu_seconds();
      for (long i = 0; i < evaluations; ++i) chain.accelerations(rods, found);
      run.seconds = cpu_seconds() - started;
      return run;
    });
    JsonLine line;
    line.add("program", "limit_explicit").add("n", count).add("evaluations", evaluations);
    line.add("us_per_link_acceleration", cost.microseconds_per_step() / count, 4).print();
  });
}
