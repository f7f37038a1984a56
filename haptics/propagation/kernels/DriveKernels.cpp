#include "haptics/base/Units.h"
#include "haptics/propagation/kernels/KernelTools.h"
#include "haptics/propagation/kernels/PropagationKernels.h"

#include <algorithm>

namespace midair::haptics::kernels::MIDAIR_SET
{

void projectToUnit(
    int width, const float* zRe, const float* zIm, float* qRe, float* qIm, float* inverse)
{
    width &= ~(kLanes - 1);
#pragma omp simd aligned(zRe, zIm, qRe, qIm, inverse : 64)
    for (int i = 0; i < width; ++i)
    {
        const float x = zRe[i], y = zIm[i];
        const float square = x * x + y * y;
        const bool silent = !(square > 1e-36f);
        const float k = 1.0f / std::sqrt(silent ? 1.0f : square);
        qRe[i] = silent ? 1.0f : x * k;
        qIm[i] = silent ? 0.0f : y * k;
        inverse[i] = silent ? 0.0f : k;
    }
}

void quantisePhase(
    int width, int levels, const float* qRe, const float* qIm, float* outRe, float* outIm)
{
    width &= ~(kLanes - 1);
    const float steps = static_cast<float>(levels);
    const float step = levels > 0 ? 1.0f / steps : 0.0f;
#pragma omp simd aligned(qRe, qIm, outRe, outIm : 64)
    for (int i = 0; i < width; ++i)
    {
        const float x = qRe[i], y = qIm[i];
        const float turns = phaseTurns(x, y);
        const float nearest = rounded(turns * steps) * step;
        float sine = 0.0f, cosine = 0.0f;
        sinCosTurns(levels > 0 ? nearest : turns, sine, cosine);
        outRe[i] = cosine;
        outIm[i] = sine;
    }
}

DriveDifference compareDrives(
    int width, const float* qRe, const float* qIm, const float* beforeRe, const float* beforeIm)
{
    constexpr auto kTwoPi = static_cast<float>(base::kTwoPi);
    width &= ~(kLanes - 1);
    float steps = 0, change = 0, power = 0;
#pragma omp simd aligned(qRe, qIm, beforeRe, beforeIm : 64) reduction(+ : steps, change, power)
    for (int i = 0; i < width; ++i)
    {
        const float x = beforeRe[i] * qRe[i] + beforeIm[i] * qIm[i];
        const float y = beforeIm[i] * qRe[i] - beforeRe[i] * qIm[i];
        const float dx = qRe[i] - beforeRe[i], dy = qIm[i] - beforeIm[i];
        steps += std::fabs(phaseTurns(x, y));
        change += dx * dx + dy * dy;
        power += qRe[i] * qRe[i] + qIm[i] * qIm[i];
    }
    return {kTwoPi * steps, change, power};
}

InnerProduct innerProduct(
    int width, const float* qRe, const float* qIm, const float* beforeRe, const float* beforeIm)
{
    width &= ~(kLanes - 1);
    float re = 0, im = 0;
#pragma omp simd aligned(qRe, qIm, beforeRe, beforeIm : 64) reduction(+ : re, im)
    for (int i = 0; i < width; ++i)
    {
        re += beforeRe[i] * qRe[i] + beforeIm[i] * qIm[i];
        im += beforeIm[i] * qRe[i] - beforeRe[i] * qIm[i];
    }
    return {re, im};
}

void scaleBy(int width, float re, float im, float* qRe, float* qIm)
{
    width &= ~(kLanes - 1);
#pragma omp simd aligned(qRe, qIm : 64)
    for (int i = 0; i < width; ++i)
    {
        const float x = qRe[i], y = qIm[i];
        qRe[i] = x * re - y * im;
        qIm[i] = x * im + y * re;
    }
}

void scaleBy(int width, const float* factor, float* qRe, float* qIm)
{
    width &= ~(kLanes - 1);
#pragma omp simd aligned(factor, qRe, qIm : 64)
    for (int i = 0; i < width; ++i)
    {
        qRe[i] *= factor[i];
        qIm[i] *= factor[i];
    }
}

void turnByDistance(
    int count, const HeardFrom& from, float turn, float decay, float* gRe, float* gIm)
{
    const float *x = from.x, *y = from.y, *z = from.z;
    const float atX = from.at[0], atY = from.at[1], atZ = from.at[2];
    const float nearest = from.nearest;
#pragma omp simd
    for (int i = 0; i < count; ++i)
    {
        const float dx = x[i] - atX, dy = y[i] - atY, dz = z[i] - atZ;
        const float distance = std::sqrt(dx * dx + dy * dy + dz * dz);
        const float R = distance < nearest ? nearest : distance;
        const float a = turn * R, a2 = a * a, b = decay * R;
        const float left = 1.0f - b + 0.5f * b * b;
        const float c = left * (1.0f - a2 * (0.5f - a2 * (1.0f / 24.0f)));
        const float s = left * a * (1.0f - a2 * (1.0f / 6.0f - a2 * (1.0f / 120.0f)));
        const float re = gRe[i], im = gIm[i];
        gRe[i] = re * c + im * s;
        gIm[i] = im * c - re * s;
    }
}

} // namespace midair::haptics::kernels::MIDAIR_SET
