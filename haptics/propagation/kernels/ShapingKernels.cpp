#include "haptics/propagation/kernels/ShapingKernels.h"

#include "haptics/propagation/kernels/KernelTools.h"
#include "haptics/propagation/kernels/Register.h"

#include <algorithm>
#include <cmath>

namespace midair::haptics::kernels::MIDAIR_SET
{

namespace
{

// to_i = -Im(c G_i q_i), added to square_i as well.
MIDAIR_INLINE void jacobianRow(const std::int32_t* G,
                               int count,
                               float cRe,
                               float cIm,
                               const float* qRe,
                               const float* qIm,
                               float* to,
                               float* square)
{
#pragma omp simd aligned(G, qRe, qIm, to, square : 64)
    for (int i = 0; i < count; ++i)
    {
        const float x = qRe[i], y = qIm[i];
        const float value =
            -(lowOf(G[i]) * (cRe * y + cIm * x) + highOf(G[i]) * (cRe * x - cIm * y));
        to[i] = value;
        square[i] += value * value;
    }
}

// The inner products of e with kShapingGroup columns that are \a apart.
#ifdef MIDAIR_HAS_PAIRS
MIDAIR_INLINE void
products(const float* columns, int apart, int stride, const float* e, float* product)
{
    Register::Floats sum[kShapingGroup];
    for (Register::Floats& s : sum)
        s = Register::zero();
    for (int l = 0; l < stride; l += Register::kLanes)
    {
        const Register::Floats error = Register::load(e + l);
        for (int k = 0; k < kShapingGroup; ++k)
            sum[k] = Register::plus(sum[k], error, Register::load(columns + k * apart + l));
    }
    for (int k = 0; k < kShapingGroup; ++k)
        product[k] = Register::total(sum[k]);
}
#else
MIDAIR_INLINE void
products(const float* columns, int apart, int stride, const float* e, float* product)
{
    for (int k = 0; k < kShapingGroup; ++k)
    {
        const float* column = columns + k * apart;
        float sum = 0.0f;
#pragma omp simd aligned(column, e : 64) reduction(+ : sum)
        for (int l = 0; l < stride; ++l)
            sum += e[l] * column[l];
        product[k] = sum;
    }
}
#endif

// e += sum_k turn_k times column k.
MIDAIR_INLINE void
addColumns(const float* columns, int apart, int stride, const float* turn, float* e)
{
    static_assert(kShapingGroup == 8);
    const float *a = columns, *b = a + apart, *c = b + apart, *d = c + apart;
    const float *f = d + apart, *g = f + apart, *h = g + apart, *k = h + apart;
#pragma omp simd aligned(a, b, c, d, f, g, h, k, e : 64)
    for (int l = 0; l < stride; ++l)
    {
        const float half = turn[0] * a[l] + turn[1] * b[l] + turn[2] * c[l] + turn[3] * d[l];
        e[l] += half + (turn[4] * f[l] + turn[5] * g[l] + turn[6] * h[l] + turn[7] * k[l]);
    }
}

// sum_l (|p_l + g_l d| - aim_l)^2.
MIDAIR_INLINE float missed(int stride,
                           const float* gRe,
                           const float* gIm,
                           float dRe,
                           float dIm,
                           const float* aim,
                           const float* pRe,
                           const float* pIm)
{
    float sum = 0.0f;
#pragma omp simd aligned(gRe, gIm, aim, pRe, pIm : 64) reduction(+ : sum)
    for (int l = 0; l < stride; ++l)
    {
        const float x = pRe[l] + gRe[l] * dRe - gIm[l] * dIm;
        const float y = pIm[l] + gRe[l] * dIm + gIm[l] * dRe;
        const float e = std::sqrt(x * x + y * y) - aim[l];
        sum += e * e;
    }
    return sum;
}

} // namespace

void jacobianColumns(const std::int32_t* G,
                     int n,
                     int width,
                     int count,
                     const float* cRe,
                     const float* cIm,
                     const float* qRe,
                     const float* qIm,
                     int stride,
                     float* J,
                     float* square)
{
    constexpr int kTile = kShapingLanes, kStep = Register::kLanes;
    count &= ~(kTile - 1);
    alignas(64) float tile[kTile * kMaxWidth];
    std::fill(square, square + count, 0.0f);
    for (int row = 0; row < stride; row += kTile)
    {
        const int rows = std::min(kTile, n - row);
        for (int l = 0; l < rows; ++l)
            jacobianRow(G + width * (row + l),
                        count,
                        cRe[row + l],
                        cIm[row + l],
                        qRe,
                        qIm,
                        tile + l * count,
                        square);
        std::fill(tile + rows * count, tile + kTile * count, 0.0f);
        for (int i = 0; i < count; i += kStep)
            for (int l = 0; l < kTile; l += kStep)
                Register::transpose(tile + l * count + i, count, J + i * stride + row + l, stride);
    }
}

void shapeLevels(int count,
                 int stride,
                 const float* J,
                 const float* square,
                 float step,
                 float reach,
                 const float* wanted,
                 float* level,
                 float* e)
{
    constexpr int kGroup = kShapingGroup;
    stride &= ~(kShapingLanes - 1);
    const int each = count / kGroup;
    alignas(64) float product[kGroup], turn[kGroup];
    for (int j = 0; j < each; ++j)
    {
        const float* columns = J + j * stride;
        products(columns, each * stride, stride, e, product);
        bool any = false;
        for (int i = 0; i < kGroup; ++i)
        {
            const int lane = i * each + j;
            const float best = level[lane] - product[i] / std::max(square[lane] * step, 1e-30f);
            const float nearest =
                rounded(std::min(std::max(best, wanted[lane] - reach), wanted[lane] + reach));
            turn[i] = (nearest - level[lane]) * step;
            level[lane] = nearest;
            any = any || turn[i] != 0.0f;
        }
        if (any) addColumns(columns, each * stride, stride, turn, e);
    }
}

void shapeCoarseLevels(int count,
                       int stride,
                       const float* gRe,
                       const float* gIm,
                       float levels,
                       int reach,
                       const float* amplitude,
                       const float* wanted,
                       float* level,
                       float* qRe,
                       float* qIm,
                       const float* aim,
                       float* pRe,
                       float* pIm)
{
    stride &= ~(kShapingLanes - 1);
    for (int i = 0; i < count; ++i)
    {
        const float *re = gRe + i * stride, *im = gIm + i * stride;
        float least = 0.0f, bestRe = 0.0f, bestIm = 0.0f;
        for (int k = -reach; k <= reach; ++k)
        {
            const float tried = rounded(wanted[i]) + static_cast<float>(k);
            const float turns = tried / levels;
            float sine = 0.0f, cosine = 0.0f;
            sinCosTurns(turns - rounded(turns), sine, cosine);
            const float dRe = amplitude[i] * cosine - qRe[i];
            const float dIm = amplitude[i] * sine - qIm[i];
            const float sum = missed(stride, re, im, dRe, dIm, aim, pRe, pIm);
            if (k > -reach && !(sum < least)) continue;
            least = sum;
            level[i] = tried;
            bestRe = dRe;
            bestIm = dIm;
        }
        qRe[i] += bestRe;
        qIm[i] += bestIm;
#pragma omp simd aligned(re, im, pRe, pIm : 64)
        for (int l = 0; l < stride; ++l)
        {
            pRe[l] += re[l] * bestRe - im[l] * bestIm;
            pIm[l] += re[l] * bestIm + im[l] * bestRe;
        }
    }
}

void phaseInLevels(int width, float levels, const float* qRe, const float* qIm, float* phase)
{
    width &= ~(kShapingLanes - 1);
#pragma omp simd aligned(qRe, qIm, phase : 64)
    for (int i = 0; i < width; ++i)
        phase[i] = phaseTurns(qRe[i], qIm[i]) * levels;
}

void unitAtLevel(int width, float levels, const float* level, float* qRe, float* qIm)
{
    width &= ~(kShapingLanes - 1);
    const float turn = 1.0f / levels;
#pragma omp simd aligned(level, qRe, qIm : 64)
    for (int i = 0; i < width; ++i)
    {
        const float turns = level[i] * turn;
        float sine = 0.0f, cosine = 0.0f;
        sinCosTurns(turns - rounded(turns), sine, cosine);
        qRe[i] = cosine;
        qIm[i] = sine;
    }
}

} // namespace midair::haptics::kernels::MIDAIR_SET
