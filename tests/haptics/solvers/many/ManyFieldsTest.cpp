// Fields by the thousand against a slow reference in double precision, written apart.
#include "haptics/solvers/many/ManyFields.h"

#include "haptics/base/InputError.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdint>
#include <limits>
#include <numeric>
#include <string>
#include <vector>

#include <gtest/gtest.h>

using namespace midair;
using namespace midair::haptics;

namespace
{

constexpr int kFields = 24;
constexpr int kPoints = 12;
constexpr double kStep_rad = 2.0 * M_PI / 256.0;

/// Two facing boards of 12 x 12 transducers.
TransducerArray facing(Directivity directivity)
{
    TransducerArray array = TransducerArray::singleBoard();
    array.directivity = directivity;
    array.positions.resize(3, 288);
    array.normals.resize(3, 288);
    array.board.assign(288, 0);
    array.gain.resize(0);
    array.phaseOffset_rad = Eigen::VectorXd::LinSpaced(288, -3.0, 3.0);
    for (int i = 0; i < 288; ++i)
    {
        const int upper = i / 144, row = i % 144 / 12, column = i % 12;
        array.positions.col(i) << 0.0105 * (column - 5.5), 0.0105 * (row - 5.5),
            upper ? 0.11 : -0.11;
        array.normals.col(i) << 0.0, 0.0, upper ? -1.0 : 1.0;
        array.board[static_cast<std::size_t>(i)] = upper;
    }
    return array;
}

/// Points on a ring that moves by \a step_m a field.
std::vector<double> movingRing(int fields, int points, double step_m)
{
    std::vector<double> all;
    for (int field = 0; field < fields; ++field)
        for (int l = 0; l < points; ++l)
        {
            const double angle = 2.0 * M_PI * l / points;
            all.push_back(0.035 * std::cos(angle) - 0.5 * step_m * fields + step_m * field);
            all.push_back(0.035 * std::sin(angle));
            all.push_back(0.01 * std::sin(3.0 * angle));
        }
    return all;
}

/// The pressures of one field, Pa, by the formula alone.
std::vector<double> pressuresOf(const TransducerArray& array,
                                const double* points,
                                int count,
                                const std::uint8_t* phases)
{
    const Medium air;
    std::vector<double> result;
    for (int l = 0; l < count; ++l)
    {
        std::complex<double> p = 0.0;
        for (int i = 0; i < array.size(); ++i)
        {
            const Eigen::Vector3d d =
                Eigen::Map<const Eigen::Vector3d>(points + 3 * l) - array.positions.col(i);
            const double R = d.norm();
            const double gain = array.gain.size() > 0 ? array.gain[i] : 1.0;
            const double offset = array.phaseOffset_rad.size() > 0 ? array.phaseOffset_rad[i] : 0.0;
            p += std::polar(array.sourceAmplitude_Pa_m * gain *
                                directivity(array.directivity, d.dot(array.normals.col(i)) / R) /
                                R * std::exp(-air.attenuation(array.frequency_Hz) * R),
                            offset + 2.0 * M_PI *
                                         (phases[i] / double(ManyFields::phaseLevelsOf(array)) -
                                          R / air.wavelength(array.frequency_Hz)));
        }
        result.push_back(std::abs(p));
    }
    return result;
}

struct Achieved
{
    double rms, level_Pa;
};

/// Without targets all points are equally loud.
Achieved achieved(const std::vector<double>& pressures, const double* targets = nullptr)
{
    double py = 0.0, pp = 0.0, square = 0.0, largest = 0.0;
    const auto of = [&](std::size_t l) { return targets != nullptr ? targets[l] : 1.0; };
    for (std::size_t l = 0; l < pressures.size(); ++l)
    {
        py += pressures[l] * of(l);
        pp += of(l) * of(l);
        largest = std::max(largest, of(l));
    }
    for (std::size_t l = 0; l < pressures.size(); ++l)
        square += std::pow(pressures[l] / (py / pp * of(l)) - 1.0, 2);
    return {std::sqrt(square / static_cast<double>(pressures.size())), py / pp * largest};
}

std::vector<std::uint8_t> solved(const TransducerArray& array,
                                 const ManyFieldsOptions& options,
                                 const ManyPoints& points,
                                 std::vector<ManyFieldsFigures>* figures = nullptr)
{
    ManyFields many(array, {}, options);
    std::vector<std::uint8_t> phases(static_cast<std::size_t>(points.fields) *
                                     static_cast<std::size_t>(array.size()));
    if (figures) figures->resize(static_cast<std::size_t>(points.fields));
    many.solve(points, phases.data(), figures ? figures->data() : nullptr);
    return phases;
}

/// What solve() says about \a points; empty if it accepts them.
std::string refusalOf(const TransducerArray& array, const ManyPoints& points)
{
    try
    {
        solved(array, {}, points);
    }
    catch (const base::InputError& error)
    {
        return error.what();
    }
    return {};
}

/// The difference of two of \a levels phases, by whole turns.
int stepOf(int a, int b, int levels = 256)
{
    const int step = std::abs(a - b);
    return std::min(step, levels - step);
}

} // namespace

TEST(ManyFields, MeetTheToleranceByASlowReference)
{
    for (const Directivity directivity :
         {Directivity::T4010A1_HARMONICS, Directivity::T4010A1_TABLE, Directivity::POINT})
        for (const double tolerance : {0.01, 0.001})
            for (const int inPath : {0, 1})
            {
                SCOPED_TRACE(directivityName(directivity) + std::string(" ") +
                             std::to_string(tolerance) + " " + std::to_string(inPath));
                const TransducerArray array = facing(directivity);
                const std::vector<double> positions = movingRing(kFields, kPoints, 5e-4);
                ManyFieldsOptions options;
                options.rmsTolerance = tolerance;
                options.fieldsInPath = inPath;
                std::vector<ManyFieldsFigures> figures;
                const std::vector<std::uint8_t> phases =
                    solved(array, options, {kFields, kPoints, positions.data()}, &figures);
                for (int field = 0; field < kFields; ++field)
                {
                    const auto k = static_cast<std::size_t>(field);
                    const Achieved real = achieved(
                        pressuresOf(array, &positions[3 * kPoints * k], kPoints, &phases[288 * k]));
                    EXPECT_LT(real.rms, 1.2 * tolerance) << field;
                    // Quick rows: 1.5e-3 of an entry, most of which averages out.
                    EXPECT_NEAR(figures[k].rms, real.rms, 4e-4) << field;
                    EXPECT_NEAR(figures[k].level_Pa / real.level_Pa, 1.0, 1e-3) << field;
                    EXPECT_GT(figures[k].loudness, 0.7F) << field;
                }
            }
}

TEST(ManyFields, FollowTargetsOfEachField)
{
    const TransducerArray array = facing(Directivity::T4010A1_TABLE);
    const std::vector<double> positions = movingRing(kFields, kPoints, 5e-4);
    std::vector<double> targets;
    for (int field = 0; field < kFields; ++field)
        for (int l = 0; l < kPoints; ++l)
            targets.push_back(700.0 + 250.0 * std::sin(0.5 * l + 0.6 * field));
    const std::vector<std::uint8_t> phases =
        solved(array, {}, {kFields, kPoints, positions.data(), targets.data(), false});
    for (std::size_t k = 0; k < kFields; ++k)
        EXPECT_LT(
            achieved(pressuresOf(array, &positions[3 * kPoints * k], kPoints, &phases[288 * k]),
                     &targets[kPoints * k])
                .rms,
            0.012)
            << k;
}

TEST(ManyFields, DoNotDependOnThreads)
{
    const TransducerArray array = facing(Directivity::T4010A1_TABLE);
    const std::vector<double> positions = movingRing(kFields, kPoints, 5e-4);
    for (const int inPath : {1, 5})
    {
        ManyFieldsOptions options;
        options.fieldsInPath = inPath;
        const ManyPoints points{kFields, kPoints, positions.data()};
        const std::vector<std::uint8_t> one = solved(array, options, points);
        options.threads = 3;
        EXPECT_EQ(one, solved(array, options, points));
        // A second call on the same object gives the same.
        ManyFields many(array, {}, options);
        for (int call = 0; call < 2; ++call)
        {
            std::vector<std::uint8_t> again(one.size());
            many.solve(points, again.data());
            EXPECT_EQ(one, again) << call;
        }
    }
}

TEST(ManyFields, KeepTheBoundOnPhaseSteps)
{
    const TransducerArray array = facing(Directivity::T4010A1_TABLE);
    const std::vector<double> positions = movingRing(kFields, kPoints, 5e-4);
    for (const double tolerance : {0.01, 0.001})
        for (const int levels : {8, 24})
        {
            ManyFieldsOptions options;
            options.rmsTolerance = tolerance;
            options.largestPhaseStep_rad = levels * kStep_rad;
            std::vector<ManyFieldsFigures> figures;
            const std::vector<std::uint8_t> phases =
                solved(array, options, {kFields, kPoints, positions.data()}, &figures);
            for (std::size_t k = 1; k < kFields; ++k)
            {
                int most = 0;
                for (std::size_t i = 0; i < 288; ++i)
                    most = std::max(most, stepOf(phases[288 * k + i], phases[288 * (k - 1) + i]));
                EXPECT_LE(most, levels) << k;
                EXPECT_NEAR(figures[k].phaseStep_rad, most * kStep_rad, 1e-5);
                // 0.5 mm turn phases by up to 15 levels; with 24 there is room for the rest.
                if (levels < 24) continue;
                const Achieved real = achieved(
                    pressuresOf(array, &positions[3 * kPoints * k], kPoints, &phases[288 * k]));
                EXPECT_LT(real.rms, 3.0 * tolerance) << k;
            }
        }
}

// Arrays of fewer phases play theirs: accurate as far as these allow, and within the bound.
TEST(ManyFields, PlayThePhasesOfTheArray)
{
    // Shipped arrays play 10, 32 and 128 phases, others some; what plain rounding leaves is the
    // estimate of SOLVER.md ("Rounding") at E = 1.
    for (const int levels : {2, 3, 10, 32, 64, 65, 128, 256})
        for (const double bound_rad : {0.0, 4.0 * 2.0 * M_PI / levels})
        {
            if (bound_rad > M_PI) continue;
            SCOPED_TRACE(std::to_string(levels) + " " + std::to_string(bound_rad));
            TransducerArray array = facing(Directivity::T4010A1_TABLE);
            array.drive.phaseLevels = levels;
            const double rounded = M_PI / std::sqrt(3.0) / levels * std::sqrt(kPoints / 288.0);
            ManyFieldsOptions options;
            options.rmsTolerance = 0.002;
            options.largestPhaseStep_rad = bound_rad;
            const std::vector<double> positions = movingRing(kFields, kPoints, 1e-4);
            std::vector<ManyFieldsFigures> figures;
            const std::vector<std::uint8_t> phases =
                solved(array, options, {kFields, kPoints, positions.data()}, &figures);
            double square = 0.0;
            for (std::size_t k = 0; k < kFields; ++k)
            {
                int most = 0;
                for (std::size_t i = 0; i < 288; ++i)
                {
                    ASSERT_LT(phases[288 * k + i], levels);
                    if (k > 0)
                        most = std::max(
                            most, stepOf(phases[288 * k + i], phases[288 * (k - 1) + i], levels));
                }
                EXPECT_LE(most, bound_rad > 0.0 ? 4 : levels) << k;
                EXPECT_NEAR(figures[k].phaseStep_rad, most * 2.0 * M_PI / levels, 1e-5) << k;
                const Achieved real = achieved(
                    pressuresOf(array, &positions[3 * kPoints * k], kPoints, &phases[288 * k]));
                EXPECT_NEAR(figures[k].rms, real.rms, 4e-4) << k;
                square += real.rms * real.rms / kFields;
            }
            // Shaping leaves less than half of what plain rounding does.
            EXPECT_LT(std::sqrt(square), std::max(0.0024, 0.5 * rounded));
            testing::Test::RecordProperty("rms_" + std::to_string(levels),
                                          std::to_string(std::sqrt(square) / rounded));
        }
}

// Every other point fades to nothing and comes back while the ring moves: the others stay, and the
// fading ones follow.
TEST(ManyFields, FadePoints)
{
    constexpr int kFading = 60;
    const TransducerArray array = facing(Directivity::T4010A1_TABLE);
    const std::vector<double> positions = movingRing(kFading, kPoints, 2e-4);
    std::vector<double> targets;
    for (int field = 0; field < kFading; ++field)
        for (int l = 0; l < kPoints; ++l)
            targets.push_back(
                l % 2 == 0 ? 1.0
                           : std::max(0.0, std::abs(1.0 - 2.0 * field / (kFading - 1.0)) - 0.05));
    ManyFieldsOptions options;
    for (const int inPath : {0, 1})
    {
        options.fieldsInPath = inPath;
        std::vector<ManyFieldsFigures> figures;
        const std::vector<std::uint8_t> phases = solved(
            array, options, {kFading, kPoints, positions.data(), targets.data(), false}, &figures);
        for (std::size_t k = 0; k < kFading; ++k)
        {
            SCOPED_TRACE(std::to_string(inPath) + " " + std::to_string(k));
            const std::vector<double> p =
                pressuresOf(array, &positions[3 * kPoints * k], kPoints, &phases[288 * k]);
            for (std::size_t l = 0; l < kPoints; ++l)
                // Of the largest target.
                EXPECT_NEAR(
                    p[l] / static_cast<double>(figures[k].level_Pa), targets[kPoints * k + l], 0.02)
                    << l;
            EXPECT_LT(figures[k].rms, 0.02F);
            EXPECT_GT(figures[k].loudness, 0.6F);
        }
    }
}

TEST(ManyFields, LeaveDeadTransducersOut)
{
    TransducerArray array = facing(Directivity::T4010A1_TABLE);
    array.setDead({0, 3, 77, 140, 141, 142, 250});
    const std::vector<double> positions = movingRing(kFields, kPoints, 5e-4);
    const std::vector<std::uint8_t> phases =
        solved(array, {}, {kFields, kPoints, positions.data()});
    for (std::size_t k = 0; k < kFields; ++k)
    {
        for (const int i : array.dead)
            EXPECT_EQ(phases[288 * k + static_cast<std::size_t>(i)], 0);
        EXPECT_LT(
            achieved(pressuresOf(array, &positions[3 * kPoints * k], kPoints, &phases[288 * k]))
                .rms,
            0.012);
    }
}

// Points at one place, more points than the array can serve, points in a transducer and a single
// one: whatever comes out, it is a number.
TEST(ManyFields, AreNeverNaN)
{
    const TransducerArray array = facing(Directivity::T4010A1_TABLE);
    std::vector<double> same(3 * 8, 0.01);
    std::vector<double> many = movingRing(1, 400, 0.0);
    std::vector<double> inside{array.positions(0, 5), array.positions(1, 5), -0.11, 0.0, 0.0, 0.0};
    for (const auto& [positions, points] :
         {std::pair(same, 8), std::pair(many, 400), std::pair(inside, 2), std::pair(inside, 1)})
    {
        std::vector<ManyFieldsFigures> figures;
        solved(array, {}, {1, points, positions.data()}, &figures);
        EXPECT_TRUE(std::isfinite(figures[0].rms)) << points;
        EXPECT_TRUE(std::isfinite(figures[0].loudness)) << points;
        EXPECT_GT(figures[0].level_Pa, 0.0F) << points;
    }
}

TEST(ManyFields, RefuseByName)
{
    const TransducerArray array = facing(Directivity::T4010A1_TABLE);
    std::vector<double> positions = movingRing(2, 4, 5e-4);
    std::vector<double> targets{1.0, 1.0, 1.0, 1.0};
    const auto refused = [&](const ManyPoints& points, const char* what) {
        EXPECT_NE(refusalOf(array, points).find(what), std::string::npos)
            << refusalOf(array, points);
    };
    EXPECT_EQ(refusalOf(array, {2, 4, positions.data(), targets.data()}), "");
    refused({0, 4, positions.data()}, "number of fields is 0");
    refused({2, 0, positions.data()}, "number of points is 0");
    refused({1, ManyFields::kMostPoints + 1, positions.data()}, "number of points is 1001");
    refused({2, 4, nullptr}, "need positions");
    for (const double bad : {-1.0, 1e13, std::nan("")})
    {
        targets[2] = bad;
        refused({2, 4, positions.data(), targets.data()}, "point 2 of field 0 has the target");
    }
    targets.assign(4, 0.0);
    refused({2, 4, positions.data(), targets.data()}, "field 0 has only targets of 0");
    positions[3 * 5 + 1] = std::numeric_limits<double>::infinity();
    refused({2, 4, positions.data()}, "point 1 of field 1 is at");
    // Behind both boards, far away.
    positions[3 * 5 + 1] = 1e6;
    refused({2, 4, positions.data()}, "point 1 of field 1 is out of the array's reach");
}

TEST(ManyFields, CheckTheirOptions)
{
    const auto refusal = [](auto change)
    {
        ManyFieldsOptions options;
        change(options);
        std::string why;
        EXPECT_FALSE(options.isValid(&why));
        return why;
    };
    EXPECT_TRUE(ManyFieldsOptions().isValid());
    EXPECT_NE(refusal([](auto& o) { o.threads = 0; }).find("threads is 0"), std::string::npos);
    EXPECT_NE(refusal([](auto& o) { o.rmsTolerance = std::nan(""); }).find("rmsTolerance"),
              std::string::npos);
    EXPECT_NE(refusal([](auto& o) { o.fieldsInPath = -1; }).find("fieldsInPath"),
              std::string::npos);
    for (const double bad : {-0.1, 3.2, std::nan("")})
        EXPECT_NE(
            refusal([&](auto& o) { o.largestPhaseStep_rad = bad; }).find("largestPhaseStep_rad"),
            std::string::npos);
    // The bound is a number of the array's phases.
    TransducerArray coarse = facing(Directivity::POINT);
    ManyFieldsOptions bounded;
    bounded.largestPhaseStep_rad = 4.0 * kStep_rad;
    EXPECT_NO_THROW(ManyFields(coarse, {}, bounded));
    coarse.drive.phaseLevels = 128;
    EXPECT_THROW(ManyFields(coarse, {}, bounded), base::InputError);
    coarse.drive.phaseLevels = 257;
    EXPECT_THROW(ManyFields(coarse, {}, {}), base::InputError);
    TransducerArray nothing;
    EXPECT_THROW(ManyFields(nothing, {}, {}), base::InputError);
    Medium frozen;
    frozen.temperature_C = -100.0;
    EXPECT_THROW(ManyFields(facing(Directivity::POINT), frozen, {}), base::InputError);
}

TEST(ManyFields, StopOnRequest)
{
    const std::vector<double> positions = movingRing(kFields, kPoints, 5e-4);
    base::StopSource source;
    source.request();
    ManyFieldsOptions options;
    options.stop = source.token();
    EXPECT_THROW(solved(facing(Directivity::POINT), options, {kFields, kPoints, positions.data()}),
                 base::Stopped);
}
