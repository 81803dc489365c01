#pragma once

#include <Eigen/Dense>

/// Eigen's dense products and decompositions of MatrixXd, compiled once, in dense.cpp and dense_eigen.cpp: otherwise
/// each costs a source that uses it two to fifteen seconds. It is in the precompiled headers of the libraries and
/// tests; nobody needs to include it, and lithe.h leaves it out. What is declared here is not instantiated where it is
/// used; what is not declared works as always. Decompositions are templates over their argument: give them a MatrixXd,
/// not an expression.
namespace Eigen {

// clang-format off
#define LITHE_DENSE_CLASSES(of) \
  of class LLT<MatrixXd>; \
  of class PartialPivLU<MatrixXd>; \
  of class FullPivLU<MatrixXd>; \
  of class HouseholderQR<MatrixXd>; \
  of class ColPivHouseholderQR<MatrixXd>; \
  of class CompleteOrthogonalDecomposition<MatrixXd>;
#define LITHE_DENSE_SOLVE(of, Method, B) of void Method<MatrixXd>::_solve_impl(const B&, B&) const;
#define LITHE_DENSE_FUNCTIONS(of) \
  of LLT<MatrixXd>& LLT<MatrixXd>::compute(const EigenBase<MatrixXd>&); \
  LITHE_DENSE_SOLVE(of, PartialPivLU, VectorXd) \
  LITHE_DENSE_SOLVE(of, PartialPivLU, MatrixXd) \
  LITHE_DENSE_SOLVE(of, ColPivHouseholderQR, VectorXd) \
  LITHE_DENSE_SOLVE(of, ColPivHouseholderQR, MatrixXd) \
  LITHE_DENSE_SOLVE(of, CompleteOrthogonalDecomposition, VectorXd) \
  LITHE_DENSE_SOLVE(of, CompleteOrthogonalDecomposition, MatrixXd)
#define LITHE_DENSE_EIGEN(of) \
  of class SelfAdjointEigenSolver<MatrixXd>; \
  of SelfAdjointEigenSolver<MatrixXd>& SelfAdjointEigenSolver<MatrixXd>::compute(const EigenBase<MatrixXd>&, int); \
  of class GeneralizedSelfAdjointEigenSolver<MatrixXd>; \
  of class EigenSolver<MatrixXd>; \
  of EigenSolver<MatrixXd>& EigenSolver<MatrixXd>::compute(const EigenBase<MatrixXd>&, bool); \
  of class JacobiSVD<MatrixXd>;
#define LITHE_DENSE_TIMES_VECTOR(of, A, b) \
  of struct general_matrix_vector_product<Index, double, const_blas_data_mapper<double, Index, A>, A, false, double, \
                                          const_blas_data_mapper<double, Index, b>, false, A == RowMajor && b == RowMajor>;
#define LITHE_DENSE_PACKED(of, Mapper, order) \
  of struct gemm_pack_lhs<double, Index, Mapper<double, Index, order>, gebp_traits<double, double>::mr, \
                          gebp_traits<double, double>::LhsProgress, gebp_traits<double, double>::LhsPacket4Packing, order, \
                          false, false>; \
  of struct gemm_pack_rhs<double, Index, Mapper<double, Index, order>, gebp_traits<double, double>::nr, order, false, false>;
#define LITHE_DENSE_PRODUCTS(of) \
  of struct general_matrix_matrix_product<Index, double, ColMajor, false, double, ColMajor, false, ColMajor, 1>; \
  of struct general_matrix_matrix_product<Index, double, ColMajor, false, double, RowMajor, false, ColMajor, 1>; \
  of struct general_matrix_matrix_product<Index, double, RowMajor, false, double, ColMajor, false, ColMajor, 1>; \
  of struct general_matrix_matrix_product<Index, double, RowMajor, false, double, RowMajor, false, ColMajor, 1>; \
  of struct triangular_solve_matrix<double, Index, OnTheLeft, Lower, false, ColMajor, ColMajor, 1>; \
  of struct triangular_solve_matrix<double, Index, OnTheLeft, Upper, false, ColMajor, ColMajor, 1>; \
  of struct triangular_solve_matrix<double, Index, OnTheLeft, UnitLower, false, ColMajor, ColMajor, 1>; \
  LITHE_DENSE_TIMES_VECTOR(of, ColMajor, RowMajor) \
  LITHE_DENSE_TIMES_VECTOR(of, ColMajor, ColMajor) \
  LITHE_DENSE_TIMES_VECTOR(of, RowMajor, ColMajor) \
  LITHE_DENSE_TIMES_VECTOR(of, RowMajor, RowMajor) \
  of struct product_triangular_matrix_matrix<double, Index, Lower, true, ColMajor, false, ColMajor, false, ColMajor, 1, 0>; \
  of struct product_triangular_matrix_matrix<double, Index, Upper, true, RowMajor, false, ColMajor, false, ColMajor, 1, 0>; \
  of struct product_triangular_matrix_matrix<double, Index, UnitUpper, true, RowMajor, false, ColMajor, false, ColMajor, 1, 0>; \
  of struct product_triangular_matrix_matrix<double, Index, UnitLower, true, ColMajor, false, ColMajor, false, ColMajor, 1, 0>; \
  of struct triangular_solve_vector<double, double, Index, OnTheLeft, UnitLower, false, ColMajor>; \
  of struct triangular_solve_vector<double, double, Index, OnTheLeft, Upper, false, ColMajor>; \
  of struct gebp_kernel<double, double, Index, blas_data_mapper<double, Index, ColMajor, Unaligned, 1>, \
                        gebp_traits<double, double>::mr, gebp_traits<double, double>::nr, false, false>; \
  LITHE_DENSE_PACKED(of, const_blas_data_mapper, ColMajor) \
  LITHE_DENSE_PACKED(of, const_blas_data_mapper, RowMajor) \
  of void evaluateProductBlockingSizesHeuristic<double, double, 1, Index>(Index&, Index&, Index&, Index); \
  of void evaluateProductBlockingSizesHeuristic<double, double, 4, Index>(Index&, Index&, Index&, Index);
// clang-format on

LITHE_DENSE_CLASSES(extern template)
LITHE_DENSE_FUNCTIONS(extern template)
LITHE_DENSE_EIGEN(extern template)
namespace internal {
LITHE_DENSE_PRODUCTS(extern template)
}

}  // namespace Eigen
