#pragma once

#include "haptics/base/AlignedBuffer.h"
#include "tests/haptics/base/simd/OnEverySet.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <random>
#include <vector>

namespace midair::haptics
{

using Complex = std::complex<double>;

/// Complex numbers as kernels take them, and what they are in double precision.
struct Split
{
    base::AlignedBuffer<float> re, im;
    std::vector<Complex> exact;

    explicit Split(int size) : exact(static_cast<std::size_t>(size))
    {
        re.reserve(exact.size());
        im.reserve(exact.size());
    }
    void set(int i, Complex value)
    {
        const auto k = static_cast<std::size_t>(i);
        re[k] = static_cast<float>(value.real());
        im[k] = static_cast<float>(value.imag());
        exact[k] = at(i);
    }
    Complex at(int i) const
    {
        const auto k = static_cast<std::size_t>(i);
        return {re[k], im[k]};
    }
};

/// Random numbers, the same in each run.
class Numbers
{
public:
    explicit Numbers(unsigned seed) : _random(seed) {}
    double between(double low, double high)
    {
        return std::uniform_real_distribution<double>(low, high)(_random);
    }
    Complex inUnitDisc() { return std::polar(std::sqrt(between(0.0, 1.0)), between(-M_PI, M_PI)); }
    Complex onUnitCircle() { return std::polar(1.0, between(-M_PI, M_PI)); }
    Split split(int size)
    {
        Split all(size);
        for (int i = 0; i < size; ++i)
            all.set(i, inUnitDisc());
        return all;
    }

private:
    std::mt19937 _random;
};

inline base::AlignedBuffer<float> floats(int size)
{
    base::AlignedBuffer<float> all;
    all.reserve(static_cast<std::size_t>(size));
    return all;
}

/// What kernels read of a lane of two numbers: the lower one exactly, the upper one with what the
/// lower adds to it.
inline double lowOf(std::int32_t pair)
{
    return static_cast<std::int16_t>(pair & 0xffff);
}
inline double highOf(std::int32_t pair)
{
    return static_cast<double>(pair) / 65536.0;
}
/// The upper number itself.
inline double exactHighOf(std::int32_t pair)
{
    return (static_cast<double>(pair) - lowOf(pair)) / 65536.0;
}

} // namespace midair::haptics
