#pragma once

#include "haptics/propagation/kernels/KernelTools.h"
#include "haptics/propagation/kernels/PropagationKernels.h"

#include <algorithm>
#include <cmath>

namespace midair::haptics::kernels
{

// Models of D as a function of the cosine of the angle to the normal, inlined into the kernels that
// build rows.

struct CubicModel
{
    DirectivityCubic D;
    MIDAIR_INLINE float largest() const { return D.largest; }
    MIDAIR_INLINE float operator()(float x) const
    {
        const float value = D.c0 + x * (D.c1 + x * (D.c2 + x * D.c3));
        return std::max(value, 0.0f);
    }
};

struct PointModel
{
    DirectivityPoint D;
    MIDAIR_INLINE float largest() const { return 1.0f; }
    MIDAIR_INLINE float operator()(float) const { return 1.0f; }
};

// log2 D is linear in theta between the table's angles. It is computed as a sum of hinge functions,
// which needs no gathers, unlike a table look-up.
struct TableModel
{
    DirectivityTable table;
    MIDAIR_INLINE float largest() const { return table.largest; }
    MIDAIR_INLINE float operator()(float x) const
    {
        // acos(x) = sqrt(1 - x) P(x), 0 <= x <= 1, minimax, 2e-8; then in steps of ten degrees.
        const float y = std::min(std::max(x, 0.0f), 1.0f);
        float P = -0.00126276826f;
        P = P * y + 0.00667108375f;
        P = P * y - 0.0170895386f;
        P = P * y + 0.0308928811f;
        P = P * y - 0.0501746613f;
        P = P * y + 0.0889790425f;
        P = P * y - 0.214598804f;
        P = P * y + 1.57079630f;
        const float step = std::sqrt(1.0f - y) * P * 5.7295779513f;
        float t = table.start + step * table.bend[0];
        for (int k = 1; k < DirectivityTable::kSteps; ++k)
            t += table.bend[k] * std::max(0.0f, step - static_cast<float>(k));
        // 2^t = (2^(t/4))^4 with a minimax polynomial for -0.65 <= t/4 <= 0, 7e-9.
        float e = 1.041982288e-06f;
        e = e * t + 3.684179282e-05f;
        e = e * t + 0.0008662909306f;
        e = e * t + 0.01501357995f;
        e = e * t + 0.1732866681f;
        e = e * t + 0.9999999955f;
        e *= e;
        return x < 0.0f ? 0.0f : e * e;
    }
};

} // namespace midair::haptics::kernels
