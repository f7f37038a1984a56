// The kernels of phase retrieval against double precision, each within what its description
// promises.
#include "haptics/propagation/kernels/PhaseKernels.h"

#include "tests/haptics/propagation/kernels/KernelTesting.h"

using namespace midair::haptics;

namespace
{

MIDAIR_ON_EVERY_SET(PhaseKernels);

int padded(int n)
{
    return (n + kernels::kPhaseLanes - 1) / kernels::kPhaseLanes * kernels::kPhaseLanes;
}

/// A Hermitian matrix, column by column.
template<typename T>
struct Matrix
{
    int n, stride;
    midair::base::AlignedBuffer<T> re, im;

    Matrix(int n, Numbers& numbers) : n(n), stride(padded(n))
    {
        re.reserve(std::size_t(n) * std::size_t(stride));
        im.reserve(std::size_t(n) * std::size_t(stride));
        for (int l = 0; l < n; ++l)
            for (int k = l; k < n; ++k)
            {
                const Complex entry = numbers.inUnitDisc();
                re[at(k, l)] = re[at(l, k)] = static_cast<T>(entry.real());
                im[at(k, l)] = static_cast<T>(k == l ? 0.0 : entry.imag());
                im[at(l, k)] = -im[at(k, l)];
            }
    }
    std::size_t at(int k, int l) const
    {
        return std::size_t(stride) * std::size_t(l) + std::size_t(k);
    }
    Complex entry(int k, int l) const { return {double(re[at(k, l)]), double(im[at(k, l)])}; }
    kernels::HermitianView<T> view() const { return {n, stride, re.data(), im.data()}; }
};

template<typename T>
struct Columns
{
    midair::base::AlignedBuffer<T> re, im;
    explicit Columns(int size)
    {
        re.reserve(std::size_t(size));
        im.reserve(std::size_t(size));
    }
    Complex at(int i) const { return {double(re[std::size_t(i)]), double(im[std::size_t(i)])}; }
    void set(int i, Complex value)
    {
        re[std::size_t(i)] = static_cast<T>(value.real());
        im[std::size_t(i)] = static_cast<T>(value.imag());
    }
};

template<typename T>
void expectProduct(int n, double part)
{
    Numbers numbers(21);
    const Matrix<T> M(n, numbers);
    Columns<T> x(M.stride), z(M.stride);
    for (int l = 0; l < n; ++l)
        x.set(l, numbers.inUnitDisc());
    kernels::multiplyMatrix(M.view(), x.re.data(), x.im.data(), z.re.data(), z.im.data());
    for (int k = 0; k < n; ++k)
    {
        Complex sum = 0.0;
        double sizes = 0.0;
        for (int l = 0; l < n; ++l)
        {
            sum += M.entry(k, l) * x.at(l);
            sizes += std::abs(M.entry(k, l) * x.at(l));
        }
        ASSERT_NEAR(std::abs(z.at(k) - sum), 0.0, part * sizes) << n;
    }
    for (int k = n; k < M.stride; ++k)
        ASSERT_EQ(z.at(k), 0.0);
}

template<typename T>
Complex objective(const Matrix<T>& M, const Columns<T>& x, int r)
{
    Complex sum = 0.0;
    for (int c = 0; c < r; ++c)
        for (int k = 0; k < M.n; ++k)
            for (int l = 0; l < M.n; ++l)
                sum += std::conj(x.at(c * M.stride + k)) * M.entry(k, l) * x.at(c * M.stride + l);
    return sum;
}

/// One round of descent in double precision, as the description says it.
template<typename T>
void descend(const Matrix<T>& M, int r, double over, std::vector<Complex>& x)
{
    const auto at = [&](int c, int l) -> Complex& { return x[std::size_t(c * M.n + l)]; };
    for (int l = 0; l < M.n; ++l)
    {
        std::vector<Complex> g(static_cast<std::size_t>(r));
        double length = 0.0;
        for (int c = 0; c < r; ++c)
        {
            for (int k = 0; k < M.n; ++k)
                if (k != l) g[std::size_t(c)] += M.entry(l, k) * at(c, k);
            length += std::norm(g[std::size_t(c)]);
        }
        length = std::sqrt(length);
        double size = 0.0;
        for (int c = 0; c < r; ++c)
        {
            const Complex t = -g[std::size_t(c)] / length;
            at(c, l) = t + over * (t - at(c, l));
            size += std::norm(at(c, l));
        }
        for (int c = 0; c < r; ++c)
            at(c, l) /= std::sqrt(size);
    }
}

template<typename T>
void expectDescent(int n, int r, double part, double ofFall, double ofColumn)
{
    Numbers numbers(22);
    const Matrix<T> M(n, numbers);
    Columns<T> x(r * M.stride), s(r * M.stride);
    std::vector<Complex> exact(static_cast<std::size_t>(r * n));
    double entries = 0.0;
    for (int l = 0; l < n; ++l)
    {
        double size = 0.0;
        for (int c = 0; c < r; ++c)
            size += std::norm(exact[std::size_t(c * n + l)] = numbers.inUnitDisc());
        for (int c = 0; c < r; ++c)
        {
            x.set(c * M.stride + l, exact[std::size_t(c * n + l)] / std::sqrt(size));
            exact[std::size_t(c * n + l)] = x.at(c * M.stride + l);
        }
        for (int k = 0; k < n; ++k)
            entries += std::abs(M.entry(k, l));
    }
    for (int c = 0; c < r; ++c)
        kernels::multiplyMatrix(M.view(),
                                x.re.data() + c * M.stride,
                                x.im.data() + c * M.stride,
                                s.re.data() + c * M.stride,
                                s.im.data() + c * M.stride);
    const Complex before = objective(M, x, r);
    const double fell = kernels::descendOnce(M.view(),
                                             r,
                                             static_cast<T>(0.5),
                                             static_cast<T>(0.0),
                                             x.re.data(),
                                             x.im.data(),
                                             s.re.data(),
                                             s.im.data());
    descend(M, r, 0.5, exact);
    EXPECT_GT(fell, 0.0);
    EXPECT_NEAR(fell, (before - objective(M, x, r)).real(), ofFall * entries);
    for (int l = 0; l < n; ++l)
    {
        double size = 0.0;
        for (int c = 0; c < r; ++c)
        {
            size += std::norm(x.at(c * M.stride + l));
            ASSERT_NEAR(
                std::abs(x.at(c * M.stride + l) - exact[std::size_t(c * n + l)]), 0.0, ofColumn)
                << n << ' ' << r;
        }
        ASSERT_NEAR(std::sqrt(size), 1.0, part);
    }
}

} // namespace

TEST_P(PhaseKernels, AddGram)
{
    Numbers numbers(23);
    for (const auto& [n, width] : {std::pair{1, 32}, {2, 416}, {7, 512}})
    {
        auto G = floats(2 * n * width);
        for (int k = 0; k < 2 * n * width; ++k)
            G[k] = static_cast<float>(numbers.between(-1.0, 1.0));
        const auto entry = [&, width = width](int l, int i)
        { return Complex(G[2 * width * l + i], G[2 * width * l + width + i]); };
        const int stride = padded(n);
        std::vector<double> re(std::size_t(n * stride), 2.0), im(std::size_t(n * stride), -1.0);
        kernels::addGram(G.data(), n, width, stride, re.data(), im.data());
        for (int l = 0; l < n; ++l)
            for (int k = 0; k < n; ++k)
            {
                const auto at = std::size_t(l * stride + k);
                Complex sum(2.0, -1.0);
                double sizes = 0.0;
                for (int i = 0; i < width && k >= l; ++i)
                {
                    sum += entry(k, i) * std::conj(entry(l, i));
                    sizes += std::abs(entry(k, i) * entry(l, i));
                }
                ASSERT_NEAR(std::abs(Complex(re[at], im[at]) - sum), 0.0, 2e-6 * sizes)
                    << n << ' ' << k << ' ' << l;
            }
    }
}

TEST_P(PhaseKernels, MultiplyMatrix)
{
    for (const int n : {1, 16, 37, 1000})
    {
        expectProduct<float>(n, 2e-6);
        expectProduct<double>(n, 1e-14);
    }
}

TEST_P(PhaseKernels, DescendOnce)
{
    for (const int n : {2, 16, 37, 200})
        for (const int r : {1, 3})
        {
            expectDescent<float>(n, r, 1e-6, 1e-5, 1e-3);
            expectDescent<double>(n, r, 1e-14, 1e-13, 1e-10);
        }
}

TEST_P(PhaseKernels, BestTurn)
{
    Numbers numbers(24);
    for (const int n : {1, 16, 37, 200})
    {
        const int length = padded(n);
        Split g(length), p(length), t(256);
        auto wanted = floats(length);
        for (int l = 0; l < n; ++l)
        {
            g.set(l, numbers.inUnitDisc());
            p.set(l, 3.0 * numbers.inUnitDisc());
            wanted[l] = static_cast<float>(numbers.between(0.0, 3.0));
        }
        for (int k = 0; k < 256; ++k)
            t.set(k, std::polar(1.0, 2 * M_PI * k / 256));
        t.set(200, t.exact[7]); // of equals the first
        const int best = kernels::bestTurn(n,
                                           256,
                                           t.re.data(),
                                           t.im.data(),
                                           g.re.data(),
                                           g.im.data(),
                                           p.re.data(),
                                           p.im.data(),
                                           wanted.data());
        ASSERT_NE(best, 200);
        double sizes = 0.0;
        std::vector<double> sums(256);
        for (int l = 0; l < n; ++l)
        {
            sizes += double(wanted[l]) + std::abs(p.exact[l]) + std::abs(g.exact[l]);
            for (int k = 0; k < 256; ++k)
                sums[k] +=
                    std::fabs(double(wanted[l]) - std::abs(p.exact[l] + g.exact[l] * t.exact[k]));
        }
        ASSERT_LE(sums[best], *std::min_element(sums.begin(), sums.end()) + 2e-6 * sizes) << n;
    }
}
