// Kernels with instructions that compilers do not choose by themselves, written with the operations
// of Register.h.
#include "haptics/propagation/kernels/KernelTools.h"
#include "haptics/propagation/kernels/PropagationKernels.h"
#include "haptics/propagation/kernels/Register.h"

#include <algorithm>
#include <cmath>

namespace midair::haptics::kernels::MIDAIR_SET
{

namespace
{

#ifdef MIDAIR_HAS_PAIRS

// With c = conj(u_l) r_i: J_li = -(Re G Im c + Im G Re c). Lanes hold pairs of 16 bits, r and u in
// units of 1/kUnity, c in units of 2^-14. Truncation, and the carry from the lower to the upper
// half of G, add errors below 3e-4 of the row's bound. J need not be exact, as both products of a
// step read the same matrix.
constexpr float kLeastFactor = 1e-30f; // if all factors are below it, they count as 0
constexpr float kUnity = 32766.0f;     // leaves room for values a little over 1

MIDAIR_INLINE std::int32_t pairOf(float low, float high)
{
    const auto bits = [](float x) { return static_cast<std::uint32_t>(std::lrint(x * kUnity)); };
    return static_cast<std::int32_t>((bits(high) << 16) | (bits(low) & 0xffffU));
}

// One row: its entries, and the factors that give -Im c and -Re c from a pair (Re r, Im r).
struct Row
{
    Register::Words im, re;
    const std::int32_t* G;
};

MIDAIR_INLINE Row rowOf(const std::int32_t* G, float uRe, float uIm)
{
    return {Register::all(pairOf(uIm, -uRe)), Register::all(pairOf(-uRe, -uIm)), G};
}

// J of one row, in units of the upper half's 2^-14.
MIDAIR_INLINE Register::Words turned(const Row& row, int i, Register::Words r)
{
    const Register::Words low = Register::down<16>(Register::pairProduct(r, row.im));
    return Register::pairProduct(Register::load(row.G + i),
                                 Register::halves(low, Register::pairProduct(r, row.re)));
}

MIDAIR_INLINE void jacobianOf(const std::int32_t* G,
                              int n,
                              int width,
                              const float* uRe,
                              const float* uIm,
                              const float* rRe,
                              const float* rIm,
                              std::int32_t* J)
{
    alignas(64) std::int32_t r[kMaxWidth];
    for (int i = 0; i < width; i += Register::kLanes)
    {
        const Register::Words x = Register::rounded(Register::load(rRe + i), kUnity);
        const Register::Words y = Register::rounded(Register::load(rIm + i), kUnity);
        Register::store(r + i, Register::halves(x, Register::up<16>(y)));
    }
    for (int l = 0; l < n; l += 2)
    {
        // The last row of an odd n has no partner: it is used twice, with u = 0.
        const bool pair = l + 1 < n;
        const std::int32_t* a = G + width * l;
        const Row first = rowOf(a, uRe[l], uIm[l]);
        const Row second =
            rowOf(pair ? a + width : a, pair ? uRe[l + 1] : 0.0f, pair ? uIm[l + 1] : 0.0f);
        std::int32_t* to = J + width * (l / 2);
        for (int i = 0; i < width; i += Register::kLanes)
        {
            const Register::Words q = Register::load(r + i);
            Register::store(to + i,
                            Register::halves(Register::down<14>(turned(first, i, q)),
                                             Register::up<2>(turned(second, i, q))));
        }
    }
}

// x in units of \a unit, pair by pair. With kMostRows pairs of rows a lane's sum stays below
// 2 * 4 * 32768 * 8190 < 2^31.
constexpr float kMostFactor = 8190.0f;
constexpr int kMostRows = 4;

template<int kRows>
MIDAIR_INLINE void
addRows(const std::int32_t* J, int width, const float* x, float perUnit, float unit, float* t)
{
    Register::Words factor[kRows];
    for (int k = 0; k < kRows; ++k)
        factor[k] = Register::all(packPair(x[2 * k] * perUnit, x[2 * k + 1] * perUnit));
    for (int i = 0; i < width; i += Register::kLanes)
    {
        Register::Words sum = Register::pairProduct(Register::load(J + i), factor[0]);
        for (int k = 1; k < kRows; ++k)
            sum = Register::sum(
                sum, Register::pairProduct(Register::load(J + k * width + i), factor[k]));
        Register::store(t + i, Register::plus(Register::load(t + i), sum, unit));
    }
}

MIDAIR_INLINE void transposedOf(const std::int32_t* J, int n, int width, const float* x, float* t)
{
    float peak = 0.0f;
    for (int l = 0; l < n; ++l)
        peak = std::max(peak, std::fabs(x[l]));
    if (!(peak > kLeastFactor)) return;
    const float perUnit = kMostFactor / peak, unit = 65536.0f * peak / kMostFactor;
    const int pairs = n / 2;
    int k = 0;
    for (; k + kMostRows <= pairs; k += kMostRows)
        addRows<kMostRows>(J + width * k, width, x + 2 * k, perUnit, unit, t);
    for (; k < pairs; ++k)
        addRows<1>(J + width * k, width, x + 2 * k, perUnit, unit, t);
}

#else

// Versions in floats for sets without products of pairs: shorter and exact.
MIDAIR_INLINE void jacobianOf(const std::int32_t* G,
                              int n,
                              int width,
                              const float* uRe,
                              const float* uIm,
                              const float* rRe,
                              const float* rIm,
                              std::int32_t* J)
{
    constexpr float kUnit = 1.0f / 65536.0f;
    for (int l = 0; l < n; l += 2)
    {
        // The last row of an odd n has no partner: it is used twice, with u = 0.
        const bool pair = l + 1 < n;
        const std::int32_t *a = G + width * l, *b = pair ? a + width : a;
        std::int32_t* row = J + width * (l / 2);
        const float ur = uRe[l] * kUnit, ui = uIm[l] * kUnit;
        const float vr = pair ? uRe[l + 1] * kUnit : 0.0f, vi = pair ? uIm[l + 1] * kUnit : 0.0f;
#pragma omp simd aligned(a, b, row, rRe, rIm : 64)
        for (int i = 0; i < width; ++i)
        {
            const float x = rRe[i], y = rIm[i];
            const float first = lowOf(a[i]) * (ui * x - ur * y) - highOf(a[i]) * (ur * x + ui * y);
            const float second = lowOf(b[i]) * (vi * x - vr * y) - highOf(b[i]) * (vr * x + vi * y);
            row[i] = packPair(first, second);
        }
    }
}

MIDAIR_INLINE void transposedOf(const std::int32_t* J, int n, int width, const float* x, float* t)
{
    int l = 0;
    for (; l + 4 <= n; l += 4)
    {
        const std::int32_t *a = J + width * (l / 2), *b = a + width;
        const float xa = x[l], xb = x[l + 1], xc = x[l + 2], xd = x[l + 3];
#pragma omp simd aligned(a, b, t : 64)
        for (int i = 0; i < width; ++i)
            t[i] += (lowOf(a[i]) * xa + highOf(a[i]) * xb) + (lowOf(b[i]) * xc + highOf(b[i]) * xd);
    }
    if (l < n)
    {
        const std::int32_t* a = J + width * (l / 2);
        const float xa = x[l], xb = x[l + 1];
#pragma omp simd aligned(a, t : 64)
        for (int i = 0; i < width; ++i)
            t[i] += lowOf(a[i]) * xa + highOf(a[i]) * xb;
    }
}

#endif

} // namespace

void inverseRoots(int count, const float* x, float* inverse)
{
    count &= ~(kLanes - 1);
    const float* __restrict from = x;
    float* __restrict to = inverse;
    for (int i = 0; i < count; i += Register::kLanes)
        Register::store(to + i, Register::inverseRoot(Register::load(from + i)));
}

void formJacobian(const std::int32_t* G,
                  int n,
                  int width,
                  const float* uRe,
                  const float* uIm,
                  const float* rRe,
                  const float* rIm,
                  std::int32_t* J)
{
    jacobianOf(G, n, width & ~(kLanes - 1), uRe, uIm, rRe, rIm, J);
}

void transposedJacobian(const std::int32_t* J, int n, int width, const float* x, float* t)
{
    width &= ~(kLanes - 1);
    std::fill(t, t + width, 0.0f);
    transposedOf(J, n, width, x, t);
}

} // namespace midair::haptics::kernels::MIDAIR_SET
