// Sums over the transducers of a block, with rows in fixed point. GCC adds the lanes of a sum one
// by one, which takes half of the loop's time, so registers are written out.
#include "haptics/propagation/kernels/KernelTools.h"
#include "haptics/propagation/kernels/PropagationKernels.h"
#include "haptics/propagation/kernels/Register.h"

namespace midair::haptics::kernels::MIDAIR_SET
{

#ifdef MIDAIR_HAS_PAIRS

namespace
{

// Rows, or pairs of rows, at a time: their sums stay in registers.
constexpr int kRows = 4;

// p of \a kCount rows.
template<int kCount>
MIDAIR_INLINE void addRows(const std::int32_t* G,
                           const float* scale,
                           int stride,
                           int width,
                           const float* qRe,
                           const float* qIm,
                           float* pRe,
                           float* pIm)
{
    Register::Floats re[kCount], im[kCount];
    for (int k = 0; k < kCount; ++k)
        re[k] = im[k] = Register::zero();
    for (int i = 0; i < width; i += Register::kLanes)
    {
        const Register::Floats x = Register::load(qRe + i), y = Register::load(qIm + i);
        for (int k = 0; k < kCount; ++k)
        {
            const Register::Words pair = Register::load(G + k * stride + i);
            const Register::Floats low = Register::low(pair), high = Register::high(pair);
            re[k] = Register::minus(Register::plus(re[k], low, x), high, y);
            im[k] = Register::plus(Register::plus(im[k], low, y), high, x);
        }
    }
    for (int k = 0; k < kCount; ++k)
    {
        pRe[k] += Register::total(re[k]) * scale[k];
        pIm[k] += Register::total(im[k]) * scale[k];
    }
}

// r of \a kCount pairs of rows.
template<int kCount>
MIDAIR_INLINE void
addPairs(const std::int32_t* J, const float* scale, int width, const float* t, float* r)
{
    Register::Floats even[kCount], odd[kCount];
    for (int k = 0; k < kCount; ++k)
        even[k] = odd[k] = Register::zero();
    for (int i = 0; i < width; i += Register::kLanes)
    {
        const Register::Floats x = Register::load(t + i);
        for (int k = 0; k < kCount; ++k)
        {
            const Register::Words pair = Register::load(J + k * width + i);
            even[k] = Register::plus(even[k], Register::low(pair), x);
            odd[k] = Register::plus(odd[k], Register::high(pair), x);
        }
    }
    for (int k = 0; k < kCount; ++k)
    {
        r[2 * k] += scale[2 * k] * Register::total(even[k]);
        r[2 * k + 1] += scale[2 * k + 1] * Register::total(odd[k]);
    }
}

} // namespace

void forward(const std::int32_t* G,
             const float* scale,
             int n,
             int stride,
             int width,
             const float* qRe,
             const float* qIm,
             float* pRe,
             float* pIm)
{
    width &= ~(kLanes - 1);
    int l = 0;
    for (; l + kRows <= n; l += kRows)
        addRows<kRows>(G + stride * l, scale + l, stride, width, qRe, qIm, pRe + l, pIm + l);
    for (; l < n; ++l)
        addRows<1>(G + stride * l, scale + l, stride, width, qRe, qIm, pRe + l, pIm + l);
}

void applyJacobian(
    const std::int32_t* J, const float* scale, int n, int width, const float* t, float* r)
{
    width &= ~(kLanes - 1);
    int l = 0;
    for (; l + 2 * kRows <= n; l += 2 * kRows)
        addPairs<kRows>(J + width * (l / 2), scale + l, width, t, r + l);
    for (; l < n; l += 2)
        addPairs<1>(J + width * (l / 2), scale + l, width, t, r + l);
}

#else

void forward(const std::int32_t* G,
             const float* scale,
             int n,
             int stride,
             int width,
             const float* qRe,
             const float* qIm,
             float* pRe,
             float* pIm)
{
    width &= ~(kLanes - 1);
    int l = 0;
    for (; l + 4 <= n; l += 4)
    {
        const std::int32_t *a = G + stride * l, *b = a + stride, *c = b + stride, *d = c + stride;
        float ar = 0, ai = 0, br = 0, bi = 0, cr = 0, ci = 0, dr = 0, di = 0;
#pragma omp simd aligned(a, b, c, d, qRe, qIm : 64) reduction(+ : ar, ai, br, bi, cr, ci, dr, di)
        for (int i = 0; i < width; ++i)
        {
            const float x = qRe[i], y = qIm[i];
            ar += lowOf(a[i]) * x;
            ar -= highOf(a[i]) * y;
            ai += lowOf(a[i]) * y;
            ai += highOf(a[i]) * x;
            br += lowOf(b[i]) * x;
            br -= highOf(b[i]) * y;
            bi += lowOf(b[i]) * y;
            bi += highOf(b[i]) * x;
            cr += lowOf(c[i]) * x;
            cr -= highOf(c[i]) * y;
            ci += lowOf(c[i]) * y;
            ci += highOf(c[i]) * x;
            dr += lowOf(d[i]) * x;
            dr -= highOf(d[i]) * y;
            di += lowOf(d[i]) * y;
            di += highOf(d[i]) * x;
        }
        pRe[l] += ar * scale[l];
        pIm[l] += ai * scale[l];
        pRe[l + 1] += br * scale[l + 1];
        pIm[l + 1] += bi * scale[l + 1];
        pRe[l + 2] += cr * scale[l + 2];
        pIm[l + 2] += ci * scale[l + 2];
        pRe[l + 3] += dr * scale[l + 3];
        pIm[l + 3] += di * scale[l + 3];
    }
    for (; l < n; ++l)
    {
        const std::int32_t* a = G + stride * l;
        float ar = 0, ai = 0;
#pragma omp simd aligned(a, qRe, qIm : 64) reduction(+ : ar, ai)
        for (int i = 0; i < width; ++i)
        {
            ar += lowOf(a[i]) * qRe[i];
            ar -= highOf(a[i]) * qIm[i];
            ai += lowOf(a[i]) * qIm[i];
            ai += highOf(a[i]) * qRe[i];
        }
        pRe[l] += ar * scale[l];
        pIm[l] += ai * scale[l];
    }
}

void applyJacobian(
    const std::int32_t* J, const float* scale, int n, int width, const float* t, float* r)
{
    width &= ~(kLanes - 1);
    int l = 0;
    for (; l + 4 <= n; l += 4)
    {
        const std::int32_t *a = J + width * (l / 2), *b = a + width;
        float ra = 0, rb = 0, rc = 0, rd = 0;
#pragma omp simd aligned(a, b, t : 64) reduction(+ : ra, rb, rc, rd)
        for (int i = 0; i < width; ++i)
        {
            ra += lowOf(a[i]) * t[i];
            rb += highOf(a[i]) * t[i];
            rc += lowOf(b[i]) * t[i];
            rd += highOf(b[i]) * t[i];
        }
        r[l] += scale[l] * ra;
        r[l + 1] += scale[l + 1] * rb;
        r[l + 2] += scale[l + 2] * rc;
        r[l + 3] += scale[l + 3] * rd;
    }
    if (l < n)
    {
        const std::int32_t* a = J + width * (l / 2);
        float ra = 0, rb = 0;
#pragma omp simd aligned(a, t : 64) reduction(+ : ra, rb)
        for (int i = 0; i < width; ++i)
        {
            ra += lowOf(a[i]) * t[i];
            rb += highOf(a[i]) * t[i];
        }
        r[l] += scale[l] * ra;
        r[l + 1] += scale[l + 1] * rb;
    }
}

#endif

} // namespace midair::haptics::kernels::MIDAIR_SET
