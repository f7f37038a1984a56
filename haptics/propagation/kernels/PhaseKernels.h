#pragma once

#include "haptics/base/simd/Kernel.h"

/// Kernels of phase retrieval, compiled for each instruction set and selected at run time. Complex
/// arrays are split into real and imaginary parts. Kernels don't allocate.
namespace midair::haptics::kernels
{

/// A Hermitian n x n matrix M, column by column: M_kl is re[l * stride + k] + j im[l * stride + k].
template<typename T>
struct HermitianView
{
    int n;
    int stride; ///< >= n, a multiple of kPhaseLanes; entries beyond n are zero
    const T* re;
    const T* im;
};

constexpr int kPhaseLanes = 16; ///< floats in the widest register

// A kernel is called like a function, and named like one.
// NOLINTBEGIN(readability-identifier-naming)
/// K += G G* over one block of a propagation matrix, lower triangle (k >= l) only, columns of \a
/// stride. G holds n rows of [re width][im width]; sums over a block are float, between blocks
/// double: K_kl within 1e-5 of sum_i |G_ki G_li|, width <= 512.
extern const base::Kernel<void(
    const float* G, int n, int width, int stride, double* kRe, double* kIm)>
    addGram;

/// z_k = sum_l M_kl x_l; vectors of \a stride. Within 2e-6 (float) or 1e-14 (double) of sum_l |M_kl
/// x_l|, n <= 1000.
template<typename T>
using MultiplyMatrix = void(const HermitianView<T>& M, const T* xRe, const T* xIm, T* zRe, T* zIm);
extern const base::Kernel<MultiplyMatrix<double>, MultiplyMatrix<float>> multiplyMatrix;

/// One round of coordinate descent on u* M u over unit columns x_l of r components (r = 1: phases):
/// in turn
///     g_l = sum_{k != l} M_lk x_k,  t_l = -g_l / |g_l|,  x_l = unit(t_l + over (t_l - x_l)).
/// t_l is the minimum. Overshooting by 0 <= \a over < 1 of the step still decreases the objective
/// and needs several times fewer rounds. Component c of x_l is at x[c * stride + l]; s holds M x
/// and is updated with x. Steps shorter than \a smallest (in |x|) are skipped, so that a round near
/// the minimum costs little. Returns the decrease of the objective. After a round |x_l| is within
/// 1e-6 (float) or 1e-14 (double) of 1 if it was before, and the returned value is within 1e-5 or
/// 1e-13 of sum_kl |M_kl| of the true decrease; n <= 1000.
template<typename T>
using DescendOnce =
    double(const HermitianView<T>& M, int r, T over, T smallest, T* xRe, T* xIm, T* sRe, T* sIm);
extern const base::Kernel<DescendOnce<double>, DescendOnce<float>> descendOnce;

/// Returns the k that minimises sum_l | wanted_l - |p_l + g_l t_k| | among \a turns factors t; the
/// first of equal ones. Sums that differ by less than 2e-6 of sum_l (wanted_l + |p_l| + |g_l t_k|)
/// may count as equal. Vectors over l are padded with zeros to a multiple of kPhaseLanes.
extern const base::Kernel<int(int n,
                              int turns,
                              const float* tRe,
                              const float* tIm,
                              const float* gRe,
                              const float* gIm,
                              const float* pRe,
                              const float* pIm,
                              const float* wanted)>
    bestTurn;
// NOLINTEND(readability-identifier-naming)

} // namespace midair::haptics::kernels
