#include "haptics/propagation/kernels/KernelTools.h"
#include "haptics/propagation/kernels/PropagationKernels.h"

#include <algorithm>

namespace midair::haptics::kernels::MIDAIR_SET
{

void turn(int width, const float* root, const float* t, float limit, float* qRe, float* qIm)
{
    constexpr float kTurns = 0.15915494309f;
    width &= ~(kLanes - 1);
#pragma omp simd aligned(root, t, qRe, qIm : 64)
    for (int i = 0; i < width; ++i)
    {
        const float angle = std::min(std::max(root[i] * t[i], -limit), limit);
        float sine = 0.0f, cosine = 0.0f;
        sinCosTurns(angle * kTurns, sine, cosine);
        const float x = qRe[i], y = qIm[i];
        qRe[i] = x * cosine - y * sine;
        qIm[i] = x * sine + y * cosine;
    }
}

} // namespace midair::haptics::kernels::MIDAIR_SET
