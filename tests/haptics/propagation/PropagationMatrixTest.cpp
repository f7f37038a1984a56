#include "haptics/propagation/PropagationMatrix.h"

#include "haptics/propagation/ReferencePropagation.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numeric>
#include <random>

#include <gtest/gtest.h>

using namespace midair::haptics;

namespace
{

Eigen::Matrix3Xd randomPoints(int n, double halfExtent_m, unsigned seed)
{
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform(-halfExtent_m, halfExtent_m);
    Eigen::Matrix3Xd points(3, n);
    for (int l = 0; l < n; ++l)
        for (int axis = 0; axis < 3; ++axis)
            points(axis, l) = uniform(random);
    return points;
}

// The largest |G - G_reference| relative to |G_reference| of the free field, or, where the
// directivity nearly vanishes, to the entry of a point source.
double
largestError(const TransducerArray& array, const Medium& medium, const Eigen::Matrix3Xd& points)
{
    PropagationMatrix G;
    G.bind(array, medium);
    G.build(points);
    const Eigen::MatrixXcd reference = referencePropagationMatrix(points, array, medium);
    TransducerArray bare = array;
    bare.reflectors.clear();
    const Eigen::MatrixXcd free = referencePropagationMatrix(points, bare, medium);
    bare.directivity = Directivity::POINT;
    const Eigen::MatrixXcd onAxis = referencePropagationMatrix(points, bare, medium);
    double error = 0.0;
    for (int l = 0; l < points.cols(); ++l)
        for (int lane = 0; lane < array.size(); ++lane)
        {
            const int i = G.order()[static_cast<std::size_t>(lane)];
            const double scale = std::max(std::abs(free(l, i)), 0.1 * std::abs(onAxis(l, i)));
            error = std::max(
                error, std::abs(std::complex<double>(G.at(l, lane)) - reference(l, i)) / scale);
        }
    return error;
}

// 1e-5 is what the product promises; a phase of 60 turns in plain float would already be 4e-5 off.
constexpr double kTolerance = 1e-5;

} // namespace

TEST(PropagationMatrix, AgreesWithTheReferenceThroughoutTheWorkspaceForEveryDirectivity)
{
    for (const Directivity model :
         {Directivity::T4010A1_HARMONICS, Directivity::T4010A1_TABLE, Directivity::POINT})
        for (TransducerArray array :
             {TransducerArray::octagonalPrism(), TransducerArray::singleBoard()})
        {
            array.directivity = model;
            EXPECT_LT(largestError(array, Medium{}, randomPoints(40, 0.15, 1)), kTolerance)
                << array.name << ' ' << directivityName(model);
        }
}

TEST(PropagationMatrix, AgreesForGainsAndPhaseOffsets)
{
    TransducerArray array = TransducerArray::octagonalPrism();
    std::mt19937 random(3);
    std::uniform_real_distribution<double> uniform(0.0, 1.0);
    array.gain.resize(array.size());
    array.phaseOffset_rad.resize(array.size());
    for (int i = 0; i < array.size(); ++i)
    {
        array.gain[i] = 0.5 + uniform(random);
        array.phaseOffset_rad[i] = 40.0 * (uniform(random) - 0.5);
    }
    EXPECT_LT(largestError(array, Medium{}, randomPoints(20, 0.1, 2)), kTolerance);
}

TEST(PropagationMatrix, AgreesInAnyAirAndAtOtherFrequencies)
{
    for (const double temperature_C : {-40.0, 0.0, 60.0})
        for (const double frequency_Hz : {25e3, 40e3, 70e3})
        {
            Medium medium;
            medium.temperature_C = temperature_C;
            medium.relativeHumidity = 0.9;
            TransducerArray array = TransducerArray::octagonalPrism();
            array.frequency_Hz = frequency_Hz;
            EXPECT_LT(largestError(array, medium, randomPoints(10, 0.12, 4)), kTolerance)
                << temperature_C << " C, " << frequency_Hz << " Hz";
        }
}

// What depends on the positions alone is kept from one air, and one set of gains, to the next.
TEST(PropagationMatrix, BoundAnewIsLikeANewOne)
{
    const Eigen::Matrix3Xd points = randomPoints(5, 0.04, 11);
    TransducerArray array = TransducerArray::octagonalPrism();
    PropagationMatrix kept;
    std::mt19937 random(12);
    for (int round = 0; round < 6; ++round)
    {
        SCOPED_TRACE(round);
        Medium air;
        air.temperature_C = 20.0 + 0.1 * round;
        array.gain.setOnes(array.size());
        array.gain[static_cast<Eigen::Index>(random() % 3984)] = 0.5;
        if (round == 3) array.setDead({5, 77}); // its order is another one
        if (round == 4) array.positions.col(9) *= 1.001;
        kept.bind(array, air);
        kept.build(points);
        PropagationMatrix fresh;
        fresh.bind(array, air);
        fresh.build(points);
        ASSERT_EQ(kept.order(), fresh.order());
        ASSERT_EQ(kept.hasSilentLanes(), fresh.hasSilentLanes());
        for (int lane = 0; lane < fresh.transducers(); ++lane)
            for (int l = 0; l < 5; ++l)
                ASSERT_EQ(kept.at(l, lane), fresh.at(l, lane)) << lane;
    }
}

TEST(PropagationMatrix, AgreesWhereTheFloatKernelDoesNotReach)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    Eigen::Matrix3Xd points(3, 5);
    points.col(0) = array.positions.col(17); // on a transducer
    points.col(1) =
        array.positions.col(400) + 1e-3 * array.normals.col(400); // a millimetre before one
    points.col(2) = array.positions.col(1000) - 0.05 * array.normals.col(1000); // behind one
    points.col(3) = Eigen::Vector3d(10.0, 0.0, 0.0);                            // 10 m away
    points.col(4) = Eigen::Vector3d(0.0, 0.9, 0.0); // along the axis, outside
    EXPECT_LT(largestError(array, Medium{}, points), kTolerance);
}

TEST(PropagationMatrix, SumsAmplitudesAndCarriesBothDirections)
{
    const TransducerArray array = TransducerArray::singleBoard(); // 249: not a multiple of a block
    const Eigen::Matrix3Xd points =
        randomPoints(7, 0.05, 5).colwise() + Eigen::Vector3d(0.0, 0.0, 0.2);
    PropagationMatrix G;
    G.bind(array, Medium{});
    G.resize(7);
    const Eigen::MatrixXcd reference = referencePropagationMatrix(points, array, Medium{});
    std::array<int, 7> rows{};
    std::array<double, 7> sums{};
    std::iota(rows.begin(), rows.end(), 0);
    for (int l = 0; l < 7; ++l)
        G.setPoint(l, points.col(l));
    for (int b = 0; b < G.blocks(); ++b)
        G.buildRows(b, rows.data(), 7, sums.data());
    for (std::size_t l = 0; l < 7; ++l)
        EXPECT_NEAR(sums[l], reference.row(static_cast<int>(l)).cwiseAbs().sum(), 1e-5 * sums[l]);

    midair::base::AlignedBuffer<float> w, q, p;
    w.reserve(14);
    p.reserve(14);
    q.reserve(static_cast<std::size_t>(2 * G.paddedTransducers()));
    float *wIm = w.data() + 7, *pIm = p.data() + 7, *qIm = q.data() + G.paddedTransducers();
    Eigen::VectorXcd exact(7);
    for (int l = 0; l < 7; ++l)
    {
        w[static_cast<std::size_t>(l)] = 0.3f * static_cast<float>(l + 1);
        wIm[l] = 1.0f - 0.2f * static_cast<float>(l);
        exact[l] = {w[static_cast<std::size_t>(l)], wIm[l]};
    }
    for (int b = 0; b < G.blocks(); ++b)
    {
        G.backward(b, w.data(), wIm, q.data(), qIm);
        G.forward(b, q.data(), qIm, p.data(), pIm);
    }
    const Eigen::VectorXcd z = reference.adjoint() * exact;
    const Eigen::VectorXcd pExact = reference * z; // order does not matter to a sum
    for (int lane = 0; lane < array.size(); ++lane)
    {
        const auto k = static_cast<std::size_t>(lane);
        EXPECT_LT(std::abs(std::complex<double>(q[k], qIm[lane]) - z[G.order()[k]]),
                  1e-5 * z.norm());
    }
    for (int l = 0; l < 7; ++l)
        EXPECT_LT(
            std::abs(std::complex<double>(p[static_cast<std::size_t>(l)], pIm[l]) - pExact[l]),
            1e-5 * pExact.norm());
}

TEST(PropagationMatrix, FixedPointHoldsItsProductsToTheSameTolerance)
{
    std::mt19937 random(11);
    std::normal_distribution<double> normal;
    TransducerArray gains = TransducerArray::octagonalPrism();
    gains.gain.setLinSpaced(gains.size(), 0.2, 2.0);
    gains.phaseOffset_rad.setLinSpaced(gains.size(), -9.0, 9.0);
    for (const TransducerArray& array : {TransducerArray::octagonalPrism(), gains})
    {
        Eigen::Matrix3Xd points = randomPoints(9, 0.1, 6);
        points.col(4) = array.positions.col(90) + 0.01 * array.normals.col(90); // next to one
        points.col(7) = Eigen::Vector3d(0.0, 3.0, 0.0);                         // far off
        const Eigen::MatrixXcd G = referencePropagationMatrix(points, array, Medium{});
        PropagationMatrix fixed(Storage::FIXED);
        fixed.bind(array, Medium{});
        fixed.build(points);
        const auto m = static_cast<std::size_t>(fixed.paddedTransducers());

        Eigen::VectorXcd q(array.size()), w(9);
        midair::base::AlignedBuffer<float> lanes, sums, back;
        lanes.reserve(2 * m);
        back.reserve(2 * m);
        sums.reserve(18);
        for (std::size_t lane = 0; lane < fixed.order().size(); ++lane)
        {
            const int i = fixed.order()[lane];
            q[i] = std::polar(1.0, normal(random));
            lanes[lane] = static_cast<float>(q[i].real());
            lanes[m + lane] = static_cast<float>(q[i].imag());
        }
        for (int b = 0; b < fixed.blocks(); ++b)
            fixed.forward(b, lanes.data(), lanes.data() + m, sums.data(), sums.data() + 9);
        const Eigen::VectorXcd p = G * q;
        // Rounding errors add up like noise: sqrt(m) of them, of the size of 2e-5 of the largest
        // entries.
        for (int l = 0; l < 9; ++l)
            EXPECT_LT(std::abs(std::complex<double>(sums[static_cast<std::size_t>(l)],
                                                    sums[static_cast<std::size_t>(9 + l)]) -
                               p[l]),
                      1e-5 * G.row(l).cwiseAbs().sum())
                << l;

        midair::base::AlignedBuffer<float> weights;
        weights.reserve(18);
        for (std::size_t l = 0; l < 9; ++l)
        {
            w[static_cast<int>(l)] = {normal(random), normal(random)};
            weights[l] = static_cast<float>(w[static_cast<int>(l)].real());
            weights[9 + l] = static_cast<float>(w[static_cast<int>(l)].imag());
        }
        for (int b = 0; b < fixed.blocks(); ++b)
            fixed.backward(b, weights.data(), weights.data() + 9, back.data(), back.data() + m);
        const Eigen::VectorXcd z = G.adjoint() * w;
        double off = 0.0;
        for (std::size_t lane = 0; lane < fixed.order().size(); ++lane)
            off += std::norm(std::complex<double>(back[lane], back[m + lane]) -
                             z[fixed.order()[lane]]);
        EXPECT_LT(std::sqrt(off), 1e-4 * z.norm());
    }
}

TEST(PropagationMatrix, RebuildsOnlyWhatIsStale)
{
    TransducerArray array = TransducerArray::singleBoard();
    PropagationMatrix G;
    EXPECT_TRUE(G.bind(array, Medium{}));
    array.name = "another name";
    EXPECT_FALSE(G.bind(array, Medium{}));
    EXPECT_TRUE(G.resize(10));
    EXPECT_FALSE(G.resize(4));
    EXPECT_FALSE(G.resize(10));
    Medium warm;
    warm.temperature_C = 30.0;
    EXPECT_TRUE(G.bind(array, warm));
}

namespace
{

Reflector rectangle(const Eigen::Vector3d& position, const Eigen::Vector3d& normal, double size_m)
{
    Reflector one;
    one.position = position;
    one.normal = normal.normalized();
    one.along = one.normal.unitOrthogonal();
    one.size_m.setConstant(size_m);
    one.accuracy_mm = 0.2;
    return one;
}

} // namespace

// kernels::sharesTurned() adds up to 1e-4 of an image, which is at most 1.8 times as strong as a
// wave of its own.
TEST(PropagationMatrix, AgreesForReflectors)
{
    const double endless = Reflector::kEndless;
    const Reflector behind = rectangle({0.0, 0.0, 0.25}, {0.1, 0.05, -1.0}, 0.3);
    const Reflector between = rectangle({0.02, -0.01, 0.05}, {0.0, 0.2, 1.0}, 0.04);
    Reflector soft = rectangle({0.0, -0.3, 0.0}, {0.0, 1.0, 0.1}, endless);
    soft.reflection = 0.6;
    soft.reflectionPhase_rad = 1.0;
    for (TransducerArray array :
         {TransducerArray::octagonalPrism(), TransducerArray::singleBoard()})
    {
        array.reflectors = {soft};
        EXPECT_LT(largestError(array, Medium{}, randomPoints(20, 0.15, 1)), 2.0 * kTolerance);
        for (const auto& reflectors : {std::vector<Reflector>{behind},
                                       std::vector<Reflector>{between},
                                       std::vector<Reflector>{behind, between, soft}})
        {
            array.reflectors = reflectors;
            EXPECT_LT(largestError(array, Medium{}, randomPoints(40, 0.15, 1)), 3e-4) << array.name;
        }
        array.reflectors = {behind};
        array.reflectors.front().reflection = 0.0;
        EXPECT_LT(largestError(array, Medium{}, randomPoints(20, 0.15, 1)), kTolerance);
    }
}

TEST(PropagationMatrix, IsTheFreeOneToTheBitWithoutReflection)
{
    TransducerArray array = TransducerArray::singleBoard();
    const Eigen::Matrix3Xd points = randomPoints(20, 0.1, 3);
    for (const Storage storage : {Storage::FLOAT, Storage::FIXED})
    {
        PropagationMatrix free(storage), other(storage);
        array.reflectors.clear();
        free.bind(array, Medium{});
        free.build(points);
        array.reflectors = {rectangle({0.0, 0.0, 0.25}, {0.0, 0.0, 1.0}, 0.3)};
        array.reflectors.front().reflection = 0.0;
        EXPECT_TRUE(other.bind(array, Medium{}));
        other.build(points);
        for (int l = 0; l < points.cols(); ++l)
            for (int lane = 0; lane < array.size(); ++lane)
                ASSERT_EQ(free.at(l, lane), other.at(l, lane));
    }
}

TEST(PropagationMatrix, SumsMagnitudesOfEntriesWithReflectorsAndStoresThemInFixedPoint)
{
    TransducerArray array = TransducerArray::singleBoard();
    for (const double size_m : {0.3, Reflector::kEndless})
    {
        // Some of the points are behind it; a plane without end leaves them nothing of its sound.
        array.reflectors = {rectangle({0.0, 0.0, 0.07}, {0.1, 0.05, -1.0}, size_m)};
        array.reflectors.front().reflection = 0.8;
        const Eigen::Matrix3Xd points = randomPoints(11, 0.1, 5);
        const Eigen::MatrixXcd reference = referencePropagationMatrix(points, array, Medium{});
        for (const Storage storage : {Storage::FLOAT, Storage::FIXED})
        {
            PropagationMatrix G(storage);
            G.bind(array, Medium{});
            G.resize(11);
            std::vector<int> rows(11);
            std::iota(rows.begin(), rows.end(), 0);
            std::vector<double> sums(11, 0.0);
            for (int l = 0; l < 11; ++l)
                G.setPoint(l, points.col(l));
            for (int b = 0; b < G.blocks(); ++b)
                G.buildRows(b, rows.data(), 11, sums.data());
            for (int l = 0; l < 11; ++l)
            {
                const double exact = reference.row(l).cwiseAbs().sum();
                EXPECT_NEAR(sums[static_cast<std::size_t>(l)], exact, 3e-4 * exact);
                const double largest = reference.row(l).cwiseAbs().maxCoeff();
                for (int lane = 0; lane < array.size(); ++lane)
                    ASSERT_LT(std::abs(std::complex<double>(G.at(l, lane)) -
                                       reference(l, G.order()[static_cast<std::size_t>(lane)])),
                              3e-4 * largest);
            }
        }
    }
}

// A lone rectangle with all transducers in front of it has rows of its own in fixed point. Paths
// lie over its middle and its ends.
TEST(PropagationMatrix, StoresWavesOfATableInFixedPoint)
{
    TransducerArray array = TransducerArray::octagonalPrism();
    array.reflectors = {rectangle({0.05, -0.2, 0.0}, {0.0, 1.0, 0.0}, 0.3)};
    array.reflectors.front().reflection = 0.9;
    array.reflectors.front().reflectionPhase_rad = 4.0;
    const Eigen::Matrix3Xd points = randomPoints(37, 0.15, 8);
    const Eigen::MatrixXcd reference = referencePropagationMatrix(points, array, Medium{});
    PropagationMatrix G(Storage::FIXED);
    G.bind(array, Medium{});
    G.build(points);
    for (int l = 0; l < points.cols(); ++l)
    {
        const double largest = reference.row(l).cwiseAbs().maxCoeff();
        for (int lane = 0; lane < G.transducers(); ++lane)
        {
            if (G.isFiller(lane)) continue;
            ASSERT_LT(std::abs(std::complex<double>(G.at(l, lane)) -
                               reference(l, G.order()[static_cast<std::size_t>(lane)])),
                      2e-4 * largest)
                << l << ' ' << lane;
        }
    }
}

TEST(PropagationMatrix, IsBoundAnewWhenAReflectorMoves)
{
    TransducerArray array = TransducerArray::singleBoard();
    array.reflectors = {rectangle({0.0, 0.0, 0.25}, {0.0, 0.0, 1.0}, 0.3)};
    PropagationMatrix G;
    G.bind(array, Medium{});
    EXPECT_TRUE(G.isBoundTo(array, Medium{}));
    array.reflectors.front().position[2] += 1e-4;
    EXPECT_FALSE(G.isBoundTo(array, Medium{}));
}
