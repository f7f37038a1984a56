// Kernels that need instructions which compilers do not choose by themselves, written with the
// operations of Register.h.
#include "haptics/propagation/kernels/KernelTools.h"
#include "haptics/propagation/kernels/PropagationKernels.h"
#include "haptics/propagation/kernels/Register.h"

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
constexpr float kUnity = 32766.0f; // leaves room for values a little over 1

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
        // The last row of an odd n has no partner: its own once more, with u = 0.
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

#else

// Version in floats for sets without products of pairs: shorter and exact.
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
        // The last row of an odd n has no partner: its own once more, with u = 0.
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

} // namespace midair::haptics::kernels::MIDAIR_SET
