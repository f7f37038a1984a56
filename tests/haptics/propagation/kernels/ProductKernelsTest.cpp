// The products with G and J against double precision, each within what its description promises.
#include "haptics/propagation/kernels/PropagationKernels.h"
#include "tests/haptics/propagation/kernels/KernelTesting.h"

using namespace midair::haptics;

namespace
{

MIDAIR_ON_EVERY_SET(ProductKernels);

/// Random rows of both kinds, and what kernels read of those in fixed point.
struct Rows
{
    int n, width;
    midair::base::AlignedBuffer<float> entries, scale;
    midair::base::AlignedBuffer<std::int32_t> fixed;
    std::vector<Complex> exact, read;

    Rows(int n, int width, Numbers& numbers, bool positive = false) : n(n), width(width)
    {
        const std::size_t size = std::size_t(n) * std::size_t(width);
        entries.reserve(2 * size);
        scale.reserve(std::size_t(n));
        fixed.reserve(size);
        exact.resize(size);
        read.resize(size);
        for (int l = 0; l < n; ++l)
        {
            float* re = entries.data() + std::ptrdiff_t(2) * width * l;
            const double loud = std::pow(10.0, numbers.between(-2.0, 2.0));
            for (int i = 0; i < width; ++i)
            {
                const Complex entry = positive ? Complex(1.0, 1.0) : numbers.inUnitDisc();
                re[i] = static_cast<float>(loud * entry.real());
                re[i + width] = static_cast<float>(loud * entry.imag());
                exact[at(l, i)] = {re[i], re[i + width]};
            }
            scale[l] = kernels::packRow(width, re, re + width, fixed.data() + at(l, 0));
            for (int i = 0; i < width; ++i)
            {
                const std::int32_t lane = fixed[at(l, i)];
                read[at(l, i)] = 65536.0 * scale[l] * Complex(lowOf(lane), highOf(lane));
            }
        }
    }
    std::size_t at(int l, int i) const
    {
        return std::size_t(l) * std::size_t(width) + std::size_t(i);
    }
};

constexpr int kSizes[][2] = {{1, 32}, {2, 416}, {7, 512}, {26, 512}, {1000, 32}};

/// How far a product is from the exact one, as a part of the sum of its terms' sizes.
struct Worst
{
    double part = 0.0;
    void look(Complex found, Complex exact, double sizes)
    {
        part = std::max(part, std::abs(found - exact) / sizes);
    }
};

void expectBackward(const Rows& G, const std::vector<Complex>& of, bool fixed, const Split& w)
{
    Split z(G.width);
    if (fixed)
        kernels::backward(G.fixed.data(),
                          G.scale.data(),
                          G.n,
                          G.width,
                          w.re.data(),
                          w.im.data(),
                          z.re.data(),
                          z.im.data());
    else
        kernels::backward(
            G.entries.data(), G.n, G.width, w.re.data(), w.im.data(), z.re.data(), z.im.data());
    Worst worst;
    for (int i = 0; i < G.width; ++i)
    {
        Complex sum = 0.0;
        double sizes = 0.0;
        for (int l = 0; l < G.n; ++l)
        {
            const Complex term = std::conj(of[G.at(l, i)]) * w.exact[l];
            sum += term;
            sizes += std::abs(term);
        }
        worst.look(z.at(i), sum, sizes);
    }
    EXPECT_LT(worst.part, 2e-6) << G.n << ' ' << G.width << ' ' << fixed;
}

void expectForward(const Rows& G, const std::vector<Complex>& of, bool fixed, const Split& q)
{
    Split p(G.n);
    for (int l = 0; l < G.n; ++l)
        p.set(l, {0.25, -0.5});
    if (fixed)
        kernels::forward(G.fixed.data(),
                         G.scale.data(),
                         G.n,
                         G.width,
                         G.width,
                         q.re.data(),
                         q.im.data(),
                         p.re.data(),
                         p.im.data());
    else
        kernels::forward(
            G.entries.data(), G.n, G.width, q.re.data(), q.im.data(), p.re.data(), p.im.data());
    Worst worst;
    for (int l = 0; l < G.n; ++l)
    {
        Complex sum = p.exact[l];
        double sizes = std::abs(sum);
        for (int i = 0; i < G.width; ++i)
        {
            const Complex term = of[G.at(l, i)] * q.exact[i];
            sum += term;
            sizes += std::abs(term);
        }
        worst.look(p.at(l), sum, sizes);
    }
    EXPECT_LT(worst.part, 1e-5) << G.n << ' ' << G.width << ' ' << fixed;
}

} // namespace

TEST_P(ProductKernels, PackRow)
{
    Numbers numbers(5);
    const Rows G(7, 512, numbers);
    for (int l = 0; l < G.n; ++l)
    {
        double peak = 0.0;
        for (int i = 0; i < G.width; ++i)
            peak = std::max({peak,
                             std::fabs(G.exact[G.at(l, i)].real()),
                             std::fabs(G.exact[G.at(l, i)].imag())});
        for (int i = 0; i < G.width; ++i)
        {
            const Complex exact = G.exact[G.at(l, i)];
            const std::int32_t lane = G.fixed[G.at(l, i)];
            const double unit = 65536.0 * G.scale[l];
            ASSERT_NEAR(unit * lowOf(lane), exact.real(), 1.6e-5 * peak);
            ASSERT_NEAR(unit * exactHighOf(lane), exact.imag(), 1.6e-5 * peak);
            ASSERT_NEAR(std::abs(G.read[G.at(l, i)] - exact), 0.0, 4e-5 * peak);
        }
    }
}

TEST_P(ProductKernels, PackRowOfSilence)
{
    const auto zero = floats(64);
    midair::base::AlignedBuffer<std::int32_t> row;
    row.reserve(64);
    row[3] = 7;
    EXPECT_EQ(kernels::packRow(64, zero.data(), zero.data(), row.data()), 0.0F);
    EXPECT_EQ(row[3], 0);
}

TEST_P(ProductKernels, BackwardAndForward)
{
    Numbers numbers(6);
    for (const auto& [n, width] : kSizes)
        for (const bool positive : {false, true}) // where all errors add up, and where they don't
        {
            const Rows G(n, width, numbers, positive);
            Split w = numbers.split(n), q = numbers.split(width);
            for (int l = 0; l < n && positive; ++l)
                w.set(l, {1.0, 1.0});
            for (int i = 0; i < width && positive; ++i)
                q.set(i, {0.7, -0.7});
            expectBackward(G, G.exact, false, w);
            expectBackward(G, G.read, true, w);
            expectForward(G, G.exact, false, q);
            expectForward(G, G.read, true, q);
        }
}

MIDAIR_ON_EVERY_SET(FormJacobian);

TEST_P(FormJacobian, IsThatOfDoublePrecision)
{
    constexpr double kPeak = 32760.0;
    Numbers numbers(3);
    for (const int width : {32, 416, 512})
        for (const int n : {1, 2, 7, 26})
        {
            midair::base::AlignedBuffer<std::int32_t> G, J;
            G.reserve(std::size_t(n) * std::size_t(width));
            J.reserve(std::size_t(n + 1) / 2 * std::size_t(width));
            std::vector<Complex> g(std::size_t(n) * std::size_t(width));
            for (std::size_t k = 0; k < g.size(); ++k)
            {
                const Complex entry = kPeak * numbers.inUnitDisc();
                g[k] = {std::round(entry.real()), std::round(entry.imag())};
                G[k] = static_cast<std::int32_t>(g[k].imag() * 65536.0 + g[k].real());
            }
            Split u(n), r = numbers.split(width);
            for (int l = 0; l < n; ++l)
                u.set(l, numbers.onUnitCircle());
            r.set(0, numbers.onUnitCircle());
            kernels::formJacobian(
                G.data(), n, width, u.re.data(), u.im.data(), r.re.data(), r.im.data(), J.data());
            for (int l = 0; l < n; ++l)
                for (int i = 0; i < width; ++i)
                {
                    const std::int32_t pair = J[std::size_t(l / 2 * width + i)];
                    const double found = l % 2 == 0 ? lowOf(pair) : highOf(pair);
                    const double exact = -std::imag(std::conj(u.exact[l]) *
                                                    g[std::size_t(l * width + i)] * r.exact[i]);
                    ASSERT_NEAR(found, exact, 3e-4 * kPeak) << n << ' ' << l << ' ' << i;
                }
        }
}

MIDAIR_ON_EVERY_SET(JacobianKernels);

TEST_P(JacobianKernels, BothDirections)
{
    Numbers numbers(8);
    for (const auto& [n, width] : {std::pair{2, 32}, {6, 416}, {8, 512}, {1000, 32}})
    {
        midair::base::AlignedBuffer<std::int32_t> J;
        J.reserve(std::size_t(n / 2 * width));
        auto x = floats(n), scale = floats(n), r = floats(n), t = floats(width), in = floats(width);
        for (int k = 0; k < n / 2 * width; ++k)
            J[k] = static_cast<std::int32_t>(numbers.between(-2.1e9, 2.1e9));
        for (int l = 0; l < n; ++l)
        {
            x[l] = static_cast<float>(numbers.between(-1.0, 1.0));
            scale[l] = static_cast<float>(numbers.between(0.1, 1.0));
            r[l] = 3.0F;
        }
        for (int i = 0; i < width; ++i)
            in[i] = static_cast<float>(numbers.between(-1.0, 1.0));
        const auto entry = [&, width = width](int l, int i)
        {
            const std::int32_t pair = J[std::size_t(l / 2 * width + i)];
            return 65536.0 * (l % 2 == 0 ? lowOf(pair) : highOf(pair));
        };
        kernels::transposedJacobian(J.data(), n, width, x.data(), t.data());
        for (int i = 0; i < width; ++i)
        {
            double sum = 0.0, sizes = 0.0;
            for (int l = 0; l < n; ++l)
            {
                sum += entry(l, i) * double(x[l]);
                sizes += std::fabs(entry(l, i)); // max |x| <= 1
            }
            ASSERT_NEAR(t[i], sum, 1e-4 * sizes) << n << ' ' << width;
        }
        kernels::applyJacobian(J.data(), scale.data(), n, width, in.data(), r.data());
        for (int l = 0; l < n; ++l)
        {
            double sum = 0.0, sizes = 0.0;
            for (int i = 0; i < width; ++i)
            {
                sum += entry(l, i) * double(in[i]);
                sizes += std::fabs(entry(l, i) * double(in[i]));
            }
            ASSERT_NEAR(r[l], 3.0 + double(scale[l]) * sum, 1e-5 * (3.0 + double(scale[l]) * sizes))
                << n << ' ' << width;
        }
    }
}

TEST_P(JacobianKernels, Turn)
{
    constexpr int kWidth = 512;
    Numbers numbers(9);
    auto root = floats(kWidth), t = floats(kWidth);
    Split q = numbers.split(kWidth);
    for (int i = 0; i < kWidth; ++i)
    {
        root[i] = static_cast<float>(numbers.between(0.0, 1.0));
        t[i] = static_cast<float>(numbers.between(-2.0, 2.0));
    }
    constexpr float kLimit = 0.5F;
    kernels::turn(kWidth, root.data(), t.data(), kLimit, q.re.data(), q.im.data());
    for (int i = 0; i < kWidth; ++i)
    {
        const double angle =
            std::clamp(double(root[i]) * double(t[i]), -double(kLimit), double(kLimit));
        ASSERT_NEAR(std::abs(q.at(i) - q.exact[i] * std::polar(1.0, angle)),
                    0.0,
                    4e-7 * std::abs(q.exact[i]));
    }
}
