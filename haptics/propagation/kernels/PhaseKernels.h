#pragma once

/// The loops of phase retrieval that take the time, each compiled for plain x86-64, AVX2 and AVX-512 and chosen at run
/// time. Complex arrays are split into real and imaginary parts; no kernel allocates.
namespace midair::haptics::kernels
{

/// A Hermitian n x n matrix M, column by column: M_kl is re[l * stride + k] + j im[l * stride + k].
template<typename T>
struct HermitianView
{
    int n;
    int stride; ///< >= n, a multiple of kPhaseLanes; what is beyond n is zero
    const T* re;
    const T* im;
};

constexpr int kPhaseLanes = 16; ///< floats in the widest register

/// K += G G* over one block of a propagation matrix, lower triangle (k >= l) only, columns of \a stride. G holds n rows of
/// [re width][im width]; sums over a block are float, between blocks double.
void addGram(const float* G, int n, int width, int stride, double* kRe, double* kIm);

/// z_k = sum_l M_kl x_l; vectors of \a stride.
void multiply(
    const HermitianView<double>& M, const double* xRe, const double* xIm, double* zRe, double* zIm);
void multiply(
    const HermitianView<float>& M, const float* xRe, const float* xIm, float* zRe, float* zIm);

/// One round of coordinate descent on u* M u over unit columns x_l of r components (r = 1: phases): in turn
///     g_l = sum_{k != l} M_lk x_k,  t_l = -g_l / |g_l|,  x_l = unit(t_l + over (t_l - x_l)).
/// t_l is the minimum; going on by 0 <= \a over < 1 of the step still falls, and takes several times fewer rounds.
/// Component c of x_l is at x[c * stride + l]; s holds M x and is kept in step. Steps shorter than \a smallest (in |x|) are
/// left out, so that a round near the minimum costs little. Returns by how much the objective fell.
double descendOnce(const HermitianView<double>& M,
                   int r,
                   double over,
                   double smallest,
                   double* xRe,
                   double* xIm,
                   double* sRe,
                   double* sIm);
double descendOnce(const HermitianView<float>& M,
                   int r,
                   float over,
                   float smallest,
                   float* xRe,
                   float* xIm,
                   float* sRe,
                   float* sIm);

/// The k that makes sum_l | wanted_l - |p_l + g_l t_k| | least, among \a turns factors t; the first one of equals. Vectors
/// over l are padded with zeros to a multiple of kPhaseLanes.
int bestTurn(int n,
             int turns,
             const float* tRe,
             const float* tIm,
             const float* gRe,
             const float* gIm,
             const float* pRe,
             const float* pIm,
             const float* wanted);

} // namespace midair::haptics::kernels
