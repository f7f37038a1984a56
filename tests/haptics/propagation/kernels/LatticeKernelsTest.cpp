// The kernels of LatticeField against double precision, within what their descriptions promise.
#include "haptics/propagation/kernels/LatticeKernels.h"

#include "tests/haptics/propagation/kernels/KernelTesting.h"

#include <array>

using namespace midair::haptics;

namespace
{

MIDAIR_ON_EVERY_SET(LatticeKernels);

double directivityAt(double cosine)
{
    return 0.5 + 0.4 * cosine + 0.1 * cosine * cosine;
}

/// Sources in a plane, lengths in wavelengths.
struct Sources
{
    static constexpr int kSources = 144; // a block and some more
    midair::base::AlignedBuffer<float> arrays[8], directivity;

    explicit Sources(Numbers& numbers)
    {
        directivity.reserve(kernels::kDirectivitySteps + 2);
        for (int i = 0; i <= kernels::kDirectivitySteps + 1; ++i)
            directivity[i] =
                float(directivityAt(std::min(1.0, -1.0 + 2.0 * i / kernels::kDirectivitySteps)));
        for (auto& array : arrays)
            array.reserve(kSources);
        for (int i = 0; i < kSources; ++i)
        {
            arrays[0][i] = float(numbers.between(-8.0, 8.0));
            arrays[1][i] = float(numbers.between(-8.0, 8.0));
            arrays[2][i] = float(numbers.between(-12.0, -10.0));
            const double tilt = numbers.between(-0.3, 0.3);
            arrays[3][i] = float(std::sin(tilt));
            arrays[5][i] = float(std::cos(tilt));
            const Complex q = numbers.inUnitDisc();
            arrays[6][i] = float(q.real());
            arrays[7][i] = float(q.imag());
        }
    }
    kernels::LatticeSources view() const
    {
        return {arrays[0].data(),
                arrays[1].data(),
                arrays[2].data(),
                arrays[3].data(),
                arrays[4].data(),
                arrays[5].data(),
                arrays[6].data(),
                arrays[7].data(),
                directivity.data(),
                kSources};
    }
    /// p at a place, and the sum of the waves' sizes there.
    Complex at(const std::array<double, 3>& place, double beta, double& sizes) const
    {
        Complex sum = 0.0;
        sizes = 0.0;
        for (int i = 0; i < kSources; ++i)
        {
            std::array<double, 3> r{};
            double R = 0.0, along = 0.0;
            for (int axis = 0; axis < 3; ++axis)
            {
                r[axis] = place[axis] - double(arrays[axis][i]);
                R += r[axis] * r[axis];
                along += r[axis] * double(arrays[3 + axis][i]);
            }
            R = std::sqrt(R);
            const Complex wave = Complex(arrays[6][i], arrays[7][i]) * directivityAt(along / R) /
                                 R * std::polar(std::exp(-beta * R), -2 * M_PI * R);
            sum += wave;
            sizes += std::abs(wave);
        }
        return sum;
    }
};

} // namespace

TEST_P(LatticeKernels, MarchLattice)
{
    Numbers numbers(31);
    const Sources sources(numbers);
    const int counts[][3] = {{8, 8, 1}, {4, 5, 5}, {3, 2, 1}, {1, 7, 2}};
    for (const auto& count : counts)
    {
        kernels::LatticeTile tile{};
        tile.middle[0] = 1.5F;
        tile.middle[1] = -2.0F;
        tile.beta = 1.2e-3F;
        tile.step[0][0] = 0.1F;
        tile.step[0][1] = 0.02F;
        tile.step[1][1] = 0.1F;
        tile.step[1][2] = 0.03F;
        tile.step[2][2] = 0.1F;
        std::copy_n(count, 3, tile.count);
        std::vector<float> sums(std::size_t(2 * count[0] * count[1] * count[2]), 0.125F);
        kernels::marchLattice(sources.view(), tile, sums.data());
        std::size_t at = 0;
        for (int c = 0; c < count[2]; ++c)
            for (int b = 0; b < count[1]; ++b)
                for (int a = 0; a < count[0]; ++a, at += 2)
                {
                    const double steps[3] = {a - 0.5 * (count[0] - 1),
                                             b - 0.5 * (count[1] - 1),
                                             c - 0.5 * (count[2] - 1)};
                    std::array<double, 3> place{};
                    for (int axis = 0; axis < 3; ++axis)
                    {
                        place[axis] = double(tile.middle[axis]);
                        for (int k = 0; k < 3; ++k)
                            place[axis] += steps[k] * double(tile.step[k][axis]);
                    }
                    double sizes = 0.0;
                    const Complex exact = sources.at(place, double(tile.beta), sizes);
                    const Complex found(sums[at] - 0.125F, sums[at + 1] - 0.125F);
                    ASSERT_NEAR(std::abs(found - exact), 0.0, 1e-2 * sizes)
                        << a << ' ' << b << ' ' << c;
                }
    }
}

TEST_P(LatticeKernels, NearestSquared)
{
    Numbers numbers(32);
    const Sources sources(numbers);
    for (int trial = 0; trial < 100; ++trial)
    {
        const float middle[3] = {float(numbers.between(-9.0, 9.0)),
                                 float(numbers.between(-9.0, 9.0)),
                                 float(numbers.between(-11.0, 9.0))};
        double least = 1e30;
        for (int i = 0; i < Sources::kSources; ++i)
        {
            double square = 0.0;
            for (int axis = 0; axis < 3; ++axis)
                square += std::pow(double(middle[axis]) - double(sources.arrays[axis][i]), 2);
            least = std::min(least, square);
        }
        ASSERT_NEAR(kernels::nearestSquared(sources.view(), middle), least, 5e-7 * 144.0);
    }
}
