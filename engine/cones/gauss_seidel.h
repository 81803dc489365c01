#pragma once

#include "engine/cones/cone_problem.h"

namespace lithe {

/// Contact by contact, each solved exactly while the others are held, until none moves: nonsmooth Gauss-Seidel (Jean
/// and Moreau, 1992). Cost is linear in the contacts; a sweep transmits forces by one layer of a stack, so tall stacks
/// and heavy on light bodies need very many sweeps: use DirectConeSolver. Contacts are solved in order: the same bits
/// each time.
class GaussSeidel final : public ConeSolver {
 public:
  struct Parameters {
    int sweeps = 100;          // at most
    bool exact_blocks = true;  // false: a projected step a contact instead of its exact solution
  };
  GaussSeidel() = default;
  explicit GaussSeidel(Parameters parameters) : parameters_(parameters) {}

  std::string name() const override { return "gauss_seidel"; }
  ConeResult solve(const ConeProblem& problem, double tolerance, VectorX& r) override;
  std::unique_ptr<ConeSolver> clone() const override { return std::make_unique<GaussSeidel>(parameters_); }

 private:
  enum class Kind { one_free_body, two_free_bodies, general };
  struct Step {
    Kind kind;
    int contact, row, data;  // data: into packed_ (free bodies) or moment_blocks_ (general, six rows)
    int v[2];                // of the free bodies
    double friction;
    Matrix3 W;
    Vector3 free;
  };

  void prepare(const ConeProblem& problem, VectorX& r);
  template <int bodies>
  double relax_free(const Step& step, VectorX& r);
  double relax_general(const ConeProblem& problem, const Step& step, VectorX& r);
  Vector3 local_impulse(const Step& step, const Vector3& u, const Vector3& old) const;

  Parameters parameters_;
  std::vector<Step> steps_;
  std::vector<double> packed_;  // a free body: Hᵀ, then Y, each 6 x 3
  std::vector<Matrix6> moment_blocks_;
  VectorX v_, u_;
};

}  // namespace lithe
