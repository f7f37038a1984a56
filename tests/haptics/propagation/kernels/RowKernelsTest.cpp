// The rows of G against double precision, within what their description promises.
#include "haptics/propagation/Reflections.h"
#include "haptics/propagation/kernels/MirroredRowKernels.h"
#include "haptics/propagation/kernels/PropagationKernels.h"
#include "tests/haptics/propagation/kernels/KernelTesting.h"

#include <string>

using namespace midair::haptics;

namespace
{

MIDAIR_ON_EVERY_SET(RowKernels);

constexpr int kGroups = 3;
constexpr int kWidth = kGroups * kernels::kGroup;
constexpr int kPoints = kernels::PointBatch::kSize;

struct Vector
{
    double x, y, z;
};

Vector operator-(const Vector& a, const Vector& b)
{
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
double dot(const Vector& a, const Vector& b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
Vector unit(const Vector& a)
{
    const double length = std::sqrt(dot(a, a));
    return {a.x / length, a.y / length, a.z / length};
}

/// Three groups of transducers and a batch of points above them, lengths in wavelengths.
struct Scene
{
    midair::base::AlignedBuffer<float> x, y, z, square, nx, ny, nz, strength, offset;
    kernels::GroupGeometry groups[kGroups]{};
    kernels::BlockGeometry block{};
    kernels::PointBatch points{};

    Scene(double radius, bool planar, bool withOffset, Numbers& numbers)
    {
        for (auto* all : {&x, &y, &z, &square, &nx, &ny, &nz, &strength, &offset})
            all->reserve(kWidth);
        for (int g = 0; g < kGroups; ++g)
            addGroup(g, radius, planar, numbers);
        block = {x.data(),
                 y.data(),
                 z.data(),
                 square.data(),
                 nx.data(),
                 ny.data(),
                 nz.data(),
                 strength.data(),
                 withOffset ? offset.data() : nullptr,
                 groups,
                 kWidth};
        points.count = kPoints;
        for (int k = 0; k < kPoints; ++k)
        {
            points.x[k] = numbers.between(-20.0, 20.0);
            points.y[k] = numbers.between(-20.0, 20.0);
            points.z[k] = numbers.between(k == 0 ? 0.3 : 1.0, 25.0);
            points.row[k] = kPoints - 1 - k;
        }
    }

    void addGroup(int g, double radius, bool planar, Numbers& numbers)
    {
        const Vector normal = unit({0.1 * g, 0.0, 1.0});
        kernels::GroupGeometry& group = groups[g];
        group = {10.0 * (g - 1),
                 2.0 * g,
                 -1.0 - g,
                 float(normal.x),
                 float(normal.y),
                 float(normal.z),
                 0.0F,
                 0.0F,
                 planar};
        for (int i = g * kernels::kGroup; i < (g + 1) * kernels::kGroup; ++i)
        {
            Vector at{numbers.between(-0.5, 0.5) * radius, numbers.between(-0.5, 0.5) * radius, 0};
            at.z = planar ? -(at.x * normal.x + at.y * normal.y) / normal.z
                          : numbers.between(-0.5, 0.5) * radius;
            const Vector n =
                planar ? normal : unit({numbers.between(-0.4, 0.4), numbers.between(-0.4, 0.4), 1});
            x[i] = float(at.x);
            y[i] = float(at.y);
            z[i] = float(at.z);
            const Vector own{x[i], y[i], z[i]};
            square[i] = float(dot(own, own));
            nx[i] = float(n.x);
            ny[i] = float(n.y);
            nz[i] = float(n.z);
            strength[i] = float(numbers.between(5.0, 20.0));
            offset[i] = float(numbers.between(-0.5, 0.5));
            group.radius = std::max(group.radius, float(std::sqrt(dot(own, own)) * 1.00001));
            group.strongest = std::max(group.strongest, strength[i]);
        }
    }

    /// G of one point and transducer, and what its size is without D.
    template<typename Model>
    Complex entry(int point, int i, double decay, Model D, double& size) const
    {
        const auto& group = groups[i / kernels::kGroup];
        const Vector place{group.x + double(x[i]), group.y + double(y[i]), group.z + double(z[i])};
        const Vector r = Vector{points.x[point], points.y[point], points.z[point]} - place;
        const double R = std::sqrt(dot(r, r));
        const double cosine = (double(nx[i]) * r.x + double(ny[i]) * r.y + double(nz[i]) * r.z) / R;
        size = double(strength[i]) / R * std::exp(-decay * R);
        const double turns = (block.offset_turns ? double(offset[i]) : 0.0) - R;
        return size * D(cosine) * std::polar(1.0, 2 * M_PI * std::remainder(turns, 1.0));
    }
};

/// The largest error, as a part of what the description allows.
template<typename Model, typename Build>
void expectRows(const Scene& scene, double decay, double largest, Model D, Build build)
{
    auto entries = floats(2 * kWidth * kPoints), scale = floats(kPoints);
    midair::base::AlignedBuffer<std::int32_t> fixed;
    fixed.reserve(std::size_t(kWidth) * kPoints);
    float sums[kPoints], fixedSums[kPoints];
    build(kernels::FloatRows{entries.data()}, sums);
    build(kernels::FixedRows{fixed.data(), scale.data()}, fixedSums);
    double radius = 0.0;
    for (const auto& group : scene.groups)
        radius = std::max(radius, double(group.radius));
    const double allowed = 7e-5 + std::pow(decay * radius, 3) / 6.0;
    double worst = 0.0;
    for (int k = 0; k < kPoints; ++k)
    {
        const int row = scene.points.row[k];
        double sum = 0.0;
        for (int i = 0; i < kWidth; ++i)
        {
            double size = 0.0;
            const Complex exact = scene.entry(k, i, decay, D, size);
            const float* re = entries.data() + std::ptrdiff_t(2) * kWidth * row;
            worst = std::max(worst,
                             std::abs(Complex(re[i], re[i + kWidth]) - exact) / (size * largest));
            sum += std::abs(exact);
            // A unit of the fixed point is a part of a bound of the row's entries.
            const std::int32_t lane = fixed[std::size_t(kWidth * row + i)];
            const double unit = 65536.0 * double(scale[row]);
            ASSERT_LE(std::abs(unit * Complex(lowOf(lane), exactHighOf(lane)) - exact),
                      allowed * size * largest + 0.8 * unit);
        }
        ASSERT_NEAR(sums[k], sum, (allowed + 2e-6) * sum * largest);
        ASSERT_NEAR(fixedSums[k], sum, (allowed + 2e-6) * sum * largest);
        // The bound is no looser than by what the groups' sizes and the directivity make it.
        ASSERT_GT(65536.0 * double(scale[row]) * 32760.0, sum / kWidth);
    }
    EXPECT_LT(worst, allowed);
    testing::Test::RecordProperty("worst", std::to_string(worst / allowed));
}

/// Quick rows against what their description allows.
template<typename Model, typename Build>
void expectQuickRows(const Scene& scene, double decay, double largest, Model D, Build build)
{
    auto scale = floats(kPoints);
    midair::base::AlignedBuffer<std::int32_t> fixed;
    fixed.reserve(std::size_t(kWidth) * kPoints);
    float sums[kPoints];
    build(kernels::QuickRows{{fixed.data(), scale.data()}}, sums);
    double radius = 0.0, worst = 0.0;
    for (const auto& group : scene.groups)
        radius = std::max(radius, double(group.radius));
    for (int k = 0; k < kPoints; ++k)
    {
        const int row = scene.points.row[k];
        const double unit = 65536.0 * double(scale[row]);
        double sum = 0.0;
        for (int i = 0; i < kWidth; ++i)
        {
            double size = 0.0;
            const Complex exact = scene.entry(k, i, decay, D, size);
            const auto& group = scene.groups[i / kernels::kGroup];
            const Vector place{group.x + double(scene.x[i]),
                               group.y + double(scene.y[i]),
                               group.z + double(scene.z[i])};
            const Vector r =
                Vector{scene.points.x[k], scene.points.y[k], scene.points.z[k]} - place;
            const double R = std::sqrt(dot(r, r));
            const double allowed = 1.5e-3 + 5e-6 * R + std::pow(decay * radius, 2) / 2.0;
            const std::int32_t lane = fixed[std::size_t(kWidth * row + i)];
            const double error = std::abs(unit * Complex(lowOf(lane), exactHighOf(lane)) - exact);
            worst = std::max(worst, error / (allowed * size * largest + 1.5 * unit));
            sum += std::abs(exact);
        }
        ASSERT_NEAR(sums[k], sum, (1.5e-3 + std::pow(decay * radius, 2) / 2.0) * sum * largest);
    }
    EXPECT_LT(worst, 1.0);
    testing::Test::RecordProperty("worst", std::to_string(worst));
}

/// Calls check(scene, decay) for scenes of all kinds.
template<typename Check>
void onEveryScene(Numbers& numbers, Check check)
{
    for (const double radius : {2.0, kernels::kLargestRadius})
        for (const bool planar : {false, true})
            for (const bool withOffset : {false, true})
                for (const double decay : {0.0, 1.2e-3, 1.0 / 60.0})
                {
                    SCOPED_TRACE(std::to_string(radius) + (planar ? " planar" : "") +
                                 (withOffset ? " offset " : " ") + std::to_string(decay));
                    const Scene scene(radius, planar, withOffset, numbers);
                    check(scene, decay);
                }
}

template<typename Model, typename Test>
void onEveryScene(Numbers& numbers, double largest, Model D, Test test)
{
    onEveryScene(numbers,
                 [&](const Scene& scene, double decay)
                 { expectRows(scene, decay, largest, D, test(scene, float(decay))); });
}

constexpr kernels::DirectivityCubic kCubic{1.0F, 0.05F, 0.55F, 0.6F, -0.2F};

double valueOf(const kernels::DirectivityCubic& cubic, double x)
{
    return std::max(0.0,
                    double(cubic.c0) +
                        x * (double(cubic.c1) + x * (double(cubic.c2) + x * double(cubic.c3))));
}

kernels::DirectivityTable someTable()
{
    kernels::DirectivityTable table{1.0F, 0.0F, {-0.05F}};
    for (int k = 1; k < kernels::DirectivityTable::kSteps; ++k)
        table.bend[k] = k % 3 == 0 ? 0.04F : -0.07F;
    return table;
}

double valueOf(const kernels::DirectivityTable& table, double x)
{
    if (x < 0.0) return 0.0;
    const double step = std::acos(std::min(1.0, x)) * 18.0 / M_PI;
    double log2 = double(table.start) + step * double(table.bend[0]);
    for (int k = 1; k < kernels::DirectivityTable::kSteps; ++k)
        log2 += double(table.bend[k]) * std::max(0.0, step - k);
    return std::exp2(log2);
}

/// A reflector behind all transducers of a scene, as its kernels see it.
struct SheetBehind
{
    Reflector sheet;
    midair::base::AlignedBuffer<float> height = floats(kWidth), along = floats(kWidth),
                                       across = floats(kWidth);
    kernels::MirrorEnds ends{};

    SheetBehind(const Scene& scene, bool withEnds)
    {
        sheet.position = {1.0, -2.0, -9.0};
        if (withEnds) sheet.size_m = {16.0, 30.0};
        for (int i = 0; i < kWidth; ++i)
        {
            const Eigen::Vector3d d = placeOf(scene, i) - sheet.position;
            height[i] = float(d.dot(sheet.normal));
            along[i] = float(d.dot(sheet.along));
            across[i] = float(d.dot(sheet.across()));
        }
        ends.sheet = {{height.data(), along.data(), across.data()}, 8.0F, 15.0F};
        for (int k = 0; k < kPoints; ++k)
        {
            const Eigen::Vector3d d = pointOf(scene.points, k) - sheet.position;
            ends.points[k] = {float(d.dot(sheet.normal)),
                              float(d.dot(sheet.along)),
                              float(d.dot(sheet.across()))};
        }
    }
    static Eigen::Vector3d placeOf(const Scene& scene, int i)
    {
        const auto& group = scene.groups[i / kernels::kGroup];
        return {group.x + double(scene.x[i]),
                group.y + double(scene.y[i]),
                group.z + double(scene.z[i])};
    }
    static Eigen::Vector3d pointOf(const kernels::PointBatch& points, int k)
    {
        return {points.x[k], points.y[k], points.z[k]};
    }
    kernels::PointBatch imagesOf(const kernels::PointBatch& points) const
    {
        kernels::PointBatch images = points;
        for (int k = 0; k < kPoints; ++k)
            images.z[k] = sheet.mirrored(pointOf(points, k))[2];
        return images;
    }
};

/// Rows with the waves of images against what their description allows.
template<typename Model, typename Build>
void expectMirroredRows(Scene& scene, bool withEnds, double largest, Model D, Build build)
{
    constexpr double kDecay = 1.2e-3, R = 0.8;
    const SheetBehind behind(scene, withEnds);
    const kernels::PointBatch own = scene.points, images = behind.imagesOf(own);
    const kernels::Mirror mirror{static_cast<float>(R), -0.14F, withEnds ? &behind.ends : nullptr};
    const Complex factor = std::polar(R, -0.28 * M_PI);
    const double most = withEnds ? 1.802 * R : R, share = withEnds ? 1e-4 * R : 0.0;
    auto scale = floats(kPoints);
    midair::base::AlignedBuffer<std::int32_t> fixed;
    fixed.reserve(std::size_t(kWidth) * kPoints);
    float sums[kPoints];
    build(scene.block,
          own,
          images,
          mirror,
          float(kDecay),
          kernels::FixedRows{fixed.data(), scale.data()},
          sums);
    double worst = 0.0;
    for (int k = 0; k < kPoints; ++k)
    {
        const int row = own.row[k];
        double sum = 0.0, sizes = 0.0;
        for (int i = 0; i < kWidth; ++i)
        {
            double size = 0.0, sizeOfImage = 0.0;
            scene.points = own;
            Complex exact = scene.entry(k, i, kDecay, D, size);
            scene.points = images;
            exact += factor *
                     shareTurned(behind.sheet,
                                 SheetBehind::placeOf(scene, i),
                                 SheetBehind::pointOf(own, k),
                                 1.0) *
                     scene.entry(k, i, kDecay, D, sizeOfImage);
            const std::int32_t lane = fixed[std::size_t(kWidth * row + i)];
            const double unit = 65536.0 * double(scale[row]);
            const double error = std::abs(unit * Complex(lowOf(lane), exactHighOf(lane)) - exact);
            const double bound = (size + most * sizeOfImage) * largest;
            const double allowed = 8e-5 * bound + share * sizeOfImage * largest + 0.8 * unit;
            ASSERT_LE(error, allowed) << k << ' ' << i;
            worst = std::max(worst, error / allowed);
            sum += std::abs(exact);
            sizes += bound;
        }
        ASSERT_NEAR(sums[k], sum, 1e-4 * sizes);
    }
    EXPECT_GT(worst, 0.1);
}

template<typename Model, typename Build>
void expectMirroredRows(Numbers& numbers, double largest, Model D, Build build)
{
    for (const bool planar : {false, true})
        for (const bool withOffset : {false, true})
            for (const bool withEnds : {false, true})
            {
                SCOPED_TRACE(std::string(planar ? "planar" : "") + (withOffset ? " offset" : "") +
                             (withEnds ? " ends" : ""));
                Scene scene(4.0, planar, withOffset, numbers);
                expectMirroredRows(scene, withEnds, largest, D, build);
            }
}

} // namespace

TEST_P(RowKernels, OfACubicDirectivity)
{
    Numbers numbers(11);
    const kernels::DirectivityCubic cubic = kCubic;
    const auto D = [&](double x) { return valueOf(cubic, x); };
    onEveryScene(numbers,
                 1.0,
                 D,
                 [&](const Scene& scene, float decay)
                 {
                     return [&scene, &cubic, decay](const auto& rows, float* sums)
                     { kernels::buildCubic(scene.block, scene.points, decay, cubic, rows, sums); };
                 });
}

TEST_P(RowKernels, OfADirectivityTable)
{
    Numbers numbers(12);
    const kernels::DirectivityTable table = someTable();
    const auto D = [&](double x) { return valueOf(table, x); };
    onEveryScene(numbers,
                 1.0,
                 D,
                 [&](const Scene& scene, float decay)
                 {
                     return [&scene, &table, decay](const auto& rows, float* sums)
                     { kernels::buildTable(scene.block, scene.points, decay, table, rows, sums); };
                 });
}

TEST_P(RowKernels, OfPointSources)
{
    Numbers numbers(13);
    onEveryScene(
        numbers,
        1.0,
        [](double) { return 1.0; },
        [](const Scene& scene, float decay)
        {
            return [&scene, decay](const auto& rows, float* sums)
            { kernels::buildPoint(scene.block, scene.points, decay, {}, rows, sums); };
        });
}

TEST_P(RowKernels, QuickOnesOfEveryDirectivity)
{
    Numbers numbers(14);
    const kernels::DirectivityTable table = someTable();
    onEveryScene(
        numbers,
        [&](const Scene& scene, double decay)
        {
            const auto with = [&](const auto& kernel, const auto& directivity)
            {
                return [&](const kernels::QuickRows& rows, float* sums)
                { kernel(scene.block, scene.points, float(decay), directivity, rows, sums); };
            };
            expectQuickRows(
                scene,
                decay,
                1.0,
                [](double x) { return valueOf(kCubic, x); },
                with(kernels::buildCubic, kCubic));
            expectQuickRows(
                scene,
                decay,
                1.0,
                [&](double x) { return valueOf(table, x); },
                with(kernels::buildTable, table));
            expectQuickRows(
                scene,
                decay,
                1.0,
                [](double) { return 1.0; },
                with(kernels::buildPoint, kernels::DirectivityPoint{}));
        });
}

TEST_P(RowKernels, WithTheWavesOfImages)
{
    Numbers numbers(17);
    const kernels::DirectivityCubic cubic = kCubic;
    expectMirroredRows(
        numbers,
        cubic.largest,
        [&](double x) { return valueOf(cubic, x); },
        [&](const auto& block,
            const auto& points,
            const auto& images,
            const auto& mirror,
            float decay,
            const auto& rows,
            float* sums)
        { kernels::buildMirroredCubic(block, points, images, mirror, decay, cubic, rows, sums); });
    const kernels::DirectivityTable table = someTable();
    expectMirroredRows(
        numbers,
        table.largest,
        [&](double x) { return valueOf(table, x); },
        [&](const auto& block,
            const auto& points,
            const auto& images,
            const auto& mirror,
            float decay,
            const auto& rows,
            float* sums)
        { kernels::buildMirroredTable(block, points, images, mirror, decay, table, rows, sums); });
    expectMirroredRows(
        numbers,
        1.0,
        [](double) { return 1.0; },
        [&](const auto& block,
            const auto& points,
            const auto& images,
            const auto& mirror,
            float decay,
            const auto& rows,
            float* sums)
        { kernels::buildMirroredPoint(block, points, images, mirror, decay, {}, rows, sums); });
}
