#include "haptics/propagation/kernels/PhaseKernels.h"

#include "haptics/propagation/kernels/KernelTools.h"

#include <cmath>

namespace midair::haptics::kernels::MIDAIR_SET
{

namespace
{

// K_kl = sum_i G_ki conj(G_li) for rows k, k + 1 and l, l + 1 at once: eight sums from eight
// vectors per step.
MIDAIR_INLINE void gramTile(const float* a,
                            const float* b,
                            const float* c,
                            const float* d,
                            int width,
                            double* re,
                            double* im)
{
    float acRe = 0, acIm = 0, adRe = 0, adIm = 0, bcRe = 0, bcIm = 0, bdRe = 0, bdIm = 0;
#pragma omp simd reduction(+ : acRe, acIm, adRe, adIm, bcRe, bcIm, bdRe, bdIm)
    for (int i = 0; i < width; ++i)
    {
        const float ar = a[i], ai = a[i + width], br = b[i], bi = b[i + width];
        const float cr = c[i], ci = c[i + width], dr = d[i], di = d[i + width];
        acRe += ar * cr + ai * ci;
        acIm += ai * cr - ar * ci;
        adRe += ar * dr + ai * di;
        adIm += ai * dr - ar * di;
        bcRe += br * cr + bi * ci;
        bcIm += bi * cr - br * ci;
        bdRe += br * dr + bi * di;
        bdIm += bi * dr - br * di;
    }
    re[0] = acRe;
    re[1] = adRe;
    re[2] = bcRe;
    re[3] = bdRe;
    im[0] = acIm;
    im[1] = adIm;
    im[2] = bcIm;
    im[3] = bdIm;
}

// z += column l of M times (re + j im); all columns have the same padding, so no remainder loop is
// needed.
template<typename T>
MIDAIR_INLINE void addColumn(const HermitianView<T>& M, int l, T re, T im, T* zRe, T* zIm)
{
    const T* mRe = M.re + static_cast<long>(M.stride) * l;
    const T* mIm = M.im + static_cast<long>(M.stride) * l;
    const int length = M.stride & ~(kPhaseLanes - 1);
#pragma omp simd
    for (int k = 0; k < length; ++k)
    {
        zRe[k] += mRe[k] * re - mIm[k] * im;
        zIm[k] += mRe[k] * im + mIm[k] * re;
    }
}

template<typename T>
MIDAIR_INLINE void
multiplyAny(const HermitianView<T>& M, const T* xRe, const T* xIm, T* zRe, T* zIm)
{
    for (int k = 0; k < M.stride; ++k)
        zRe[k] = zIm[k] = T(0);
    for (int l = 0; l < M.n; ++l)
        addColumn(M, l, xRe[l], xIm[l], zRe, zIm);
}

template<typename T>
MIDAIR_INLINE double
descendAny(const HermitianView<T>& M, int r, T over, T smallest, T* xRe, T* xIm, T* sRe, T* sIm)
{
    double fell = 0.0;
    const long end = static_cast<long>(r) * M.stride;
    for (int l = 0; l < M.n; ++l)
    {
        const T diagonal = M.re[static_cast<long>(M.stride) * l + l];
        // |g|^2 and Re(g* x).
        T square = 0, along = 0;
        for (long at = l; at < end; at += M.stride)
        {
            const T gRe = sRe[at] - diagonal * xRe[at], gIm = sIm[at] - diagonal * xIm[at];
            square += gRe * gRe + gIm * gIm;
            along += gRe * xRe[at] + gIm * xIm[at];
        }
        const T length = std::sqrt(square);
        // |t - x|^2 = 2 (1 + Re(g* x) / |g|); a point whose row of M is zero has no gradient and
        // stays.
        if (!(T(2) * (along + length) > smallest * smallest * length)) continue;
        const T cosine = -along / length; // cosine of the angle from x to t
        const T size2 =
            (T(1) + over) * (T(1) + over) + over * over - T(2) * over * (T(1) + over) * cosine;
        const T scale = T(1) / std::sqrt(size2);
        const T toMinimum = -(T(1) + over) * scale / length, toOld = -over * scale;
        for (long row = 0; row < end; row += M.stride)
        {
            const long at = row + l;
            const T gRe = sRe[at] - diagonal * xRe[at], gIm = sIm[at] - diagonal * xIm[at];
            const T newRe = toMinimum * gRe + toOld * xRe[at];
            const T newIm = toMinimum * gIm + toOld * xIm[at];
            const T dRe = newRe - xRe[at], dIm = newIm - xIm[at];
            fell -= T(2) * (gRe * dRe + gIm * dIm);
            xRe[at] = newRe;
            xIm[at] = newIm;
            addColumn(M, l, dRe, dIm, sRe + row, sIm + row);
        }
    }
    return fell;
}

} // namespace

void addGram(const float* G, int n, int width, int stride, double* kRe, double* kIm)
{
    const auto row = [G, width](int l) { return G + static_cast<long>(2) * width * l; };
    for (int l = 0; l < n; l += 2)
    {
        // With an odd n the last row also stands for its missing neighbour, whose results are
        // discarded.
        const int l1 = l + 1 < n ? l + 1 : l;
        for (int k = l; k < n; k += 2)
        {
            const int k1 = k + 1 < n ? k + 1 : k;
            double re[4], im[4];
            gramTile(row(k), row(k1), row(l), row(l1), width, re, im);
            double* columnRe = kRe + static_cast<long>(stride) * l;
            double* columnIm = kIm + static_cast<long>(stride) * l;
            columnRe[k] += re[0];
            columnIm[k] += im[0];
            if (k1 > k)
            {
                columnRe[k1] += re[2];
                columnIm[k1] += im[2];
            }
            if (l1 > l && k > l)
            {
                columnRe[stride + k] += re[1];
                columnIm[stride + k] += im[1];
            }
            if (l1 > l && k1 > k)
            {
                columnRe[stride + k1] += re[3];
                columnIm[stride + k1] += im[3];
            }
        }
    }
}

void multiplyMatrix(
    const HermitianView<double>& M, const double* xRe, const double* xIm, double* zRe, double* zIm)
{
    multiplyAny(M, xRe, xIm, zRe, zIm);
}

void multiplyMatrix(
    const HermitianView<float>& M, const float* xRe, const float* xIm, float* zRe, float* zIm)
{
    multiplyAny(M, xRe, xIm, zRe, zIm);
}

double descendOnce(const HermitianView<double>& M,
                   int r,
                   double over,
                   double smallest,
                   double* xRe,
                   double* xIm,
                   double* sRe,
                   double* sIm)
{
    return descendAny(M, r, over, smallest, xRe, xIm, sRe, sIm);
}

double descendOnce(const HermitianView<float>& M,
                   int r,
                   float over,
                   float smallest,
                   float* xRe,
                   float* xIm,
                   float* sRe,
                   float* sIm)
{
    return descendAny(M, r, over, smallest, xRe, xIm, sRe, sIm);
}

int bestTurn(int n,
             int turns,
             const float* tRe,
             const float* tIm,
             const float* gRe,
             const float* gIm,
             const float* pRe,
             const float* pIm,
             const float* wanted)
{
    const int length = (n + kPhaseLanes - 1) & ~(kPhaseLanes - 1);
    int best = 0;
    float least = 0.0f;
    for (int k = 0; k < turns; ++k)
    {
        const float re = tRe[k], im = tIm[k];
        float sum = 0.0f;
#pragma omp simd reduction(+ : sum)
        for (int l = 0; l < length; ++l)
        {
            const float x = pRe[l] + gRe[l] * re - gIm[l] * im;
            const float y = pIm[l] + gRe[l] * im + gIm[l] * re;
            sum += std::fabs(wanted[l] - std::sqrt(x * x + y * y));
        }
        if (k > 0 && !(sum < least)) continue;
        least = sum;
        best = k;
    }
    return best;
}

} // namespace midair::haptics::kernels::MIDAIR_SET
