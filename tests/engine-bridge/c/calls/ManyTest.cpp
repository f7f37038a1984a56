// What midair_solve_many() takes, refuses and returns.
#include "tests/engine-bridge/c/Opened.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdint>
#include <limits>

namespace
{

constexpr std::size_t kFields = 40, kPoints = 4;

/// A square above a flat board that moves by 0.5 mm a field.
std::vector<double> movingSquare()
{
    std::vector<double> positions;
    for (std::size_t field = 0; field < kFields; ++field)
        for (std::size_t l = 0; l < kPoints; ++l)
        {
            positions.push_back((l % 2 ? 0.02 : -0.02) + 5e-4 * static_cast<double>(field) - 0.01);
            positions.push_back(l / 2 ? 0.02 : -0.02);
            positions.push_back(0.15);
        }
    return positions;
}

midair_many manyOf(const std::vector<double>& positions)
{
    midair_many many{};
    many.struct_size = sizeof many;
    many.fields = kFields;
    many.points = kPoints;
    many.positions = positions.data();
    return many;
}

/// Pressure at a place by the formula alone, up to a common factor: without directivity and air.
double pressureAt(const std::vector<midair_transducer>& all,
                  const std::uint8_t* phases,
                  double levels,
                  const double* place)
{
    constexpr double kWavelength_m = 343.2 / 40e3;
    std::complex<double> p = 0.0;
    for (std::size_t i = 0; i < all.size(); ++i)
    {
        const double R = std::hypot(place[0] - all[i].position[0],
                                    place[1] - all[i].position[1],
                                    place[2] - all[i].position[2]);
        p += std::polar(1.0 / R, 2.0 * M_PI * (phases[i] / levels - R / kWavelength_m));
    }
    return std::abs(p);
}

} // namespace

// On each kind of levels the points are several times as loud as a place between them.
TEST(CSolveMany, FocusesWithTheLevelsOfTheArray)
{
    for (const auto& [name, levels] :
         {std::pair{"board", 256U}, {"openmpd", 128U}, {"sonicsurface", 32U}, {"ultraino64", 10U}})
    {
        Opened of(name);
        const std::vector<double> positions = movingSquare();
        const midair_many many = manyOf(positions);
        midair_many_layout layout{};
        ASSERT_EQ(midair_solve_many(of.scene, &many, nullptr, 0, &layout, nullptr), MIDAIR_OK)
            << midair_last_error();
        std::size_t m = 0;
        ASSERT_EQ(midair_array_size(of.array, &m), MIDAIR_OK);
        EXPECT_EQ(layout.transducers, m);
        EXPECT_EQ(layout.phase_levels, levels);
        std::vector<std::uint8_t> phases(kFields * m);
        std::vector<midair_many_figures> figures(kFields);
        ASSERT_EQ(midair_solve_many(
                      of.scene, &many, phases.data(), phases.size(), &layout, figures.data()),
                  MIDAIR_OK)
            << midair_last_error();
        EXPECT_LT(*std::max_element(phases.begin(), phases.end()), levels);
        std::vector<midair_transducer> all(m);
        ASSERT_EQ(midair_array_transducers(of.array, all.data(), m), MIDAIR_OK);
        const std::size_t last = kFields - 1;
        const double* square = &positions[3 * kPoints * last];
        const double middle[3] = {square[0] + 0.02, 0.0, 0.15};
        const std::uint8_t* own = phases.data() + m * last;
        const double between = pressureAt(all, own, levels, middle);
        for (std::size_t l = 0; l < kPoints; ++l)
            EXPECT_GT(pressureAt(all, own, levels, square + 3 * l), 2.0 * between) << name;
        for (std::size_t k = 0; k < kFields; ++k)
        {
            EXPECT_LT(figures[k].rms, levels > 10 ? 0.011F : 0.05F) << name << ' ' << k;
            EXPECT_GT(figures[k].level_Pa, 100.0F);
            EXPECT_GT(figures[k].loudness, 0.7F);
            EXPECT_EQ(figures[k].phase_step_rad == 0.0F, k == 0);
        }
    }
}

TEST(CSolveMany, FollowsTargetsPathsBoundAndThreads)
{
    Opened of("board");
    const std::vector<double> positions = movingSquare();
    std::vector<double> targets(kFields * kPoints, 1.0);
    for (std::size_t k = 0; k < kFields; ++k)
        targets[kPoints * k] = 1.0 - static_cast<double>(k) / (kFields - 1.0); // fades to 0
    midair_many many = manyOf(positions);
    many.targets = targets.data();
    many.fields_in_path = 10;
    many.largest_phase_step_rad = 1.2;
    many.tolerance = 0.003;
    std::vector<std::uint8_t> one(kFields * 249), two(one.size());
    std::vector<midair_many_figures> figures(kFields);
    const auto solved = [&](std::vector<std::uint8_t>& phases)
    {
        return midair_solve_many(
            of.scene, &many, phases.data(), phases.size(), nullptr, figures.data());
    };
    ASSERT_EQ(solved(one), MIDAIR_OK) << midair_last_error();
    for (std::size_t k = 0; k < kFields; ++k)
    {
        EXPECT_EQ(figures[k].phase_step_rad == 0.0F, k % 10 == 0) << k;
        EXPECT_LE(figures[k].phase_step_rad, 1.2F);
        EXPECT_LT(figures[k].rms, 0.02F) << k;
    }
    ASSERT_EQ(midair_set(of.scene, "threads", "2"), MIDAIR_OK);
    ASSERT_EQ(solved(two), MIDAIR_OK) << midair_last_error();
    EXPECT_EQ(one, two);
    many.seed = 7;
    ASSERT_EQ(solved(two), MIDAIR_OK) << midair_last_error();
    EXPECT_NE(one, two);
    // The targets of the first field for all.
    many.same_targets = 1;
    ASSERT_EQ(solved(two), MIDAIR_OK) << midair_last_error();
}

TEST(CSolveMany, RefusesWithAReason)
{
    Opened of("board");
    std::vector<double> positions = movingSquare();
    std::vector<double> targets(kPoints, 1.0);
    std::vector<std::uint8_t> phases(kFields * 249, 77);
    const auto refused = [&](auto change, midair_status status, const char* why)
    {
        midair_many many = manyOf(positions);
        many.targets = targets.data();
        many.same_targets = 1;
        change(many);
        EXPECT_EQ(
            midair_solve_many(of.scene, &many, phases.data(), phases.size(), nullptr, nullptr),
            status)
            << why;
        EXPECT_NE(std::string(midair_last_error()).find(why), std::string::npos)
            << midair_last_error();
    };
    constexpr std::size_t kHuge = std::numeric_limits<std::size_t>::max();
    refused([](auto& m) { m.struct_size = 8; }, MIDAIR_INVALID, "struct_size");
    refused([](auto& m) { m.fields = 0; }, MIDAIR_INVALID, "fields is 0");
    // As many that K n 3 would overflow.
    refused([](auto& m) { m.fields = kHuge / 3; }, MIDAIR_INVALID, "fields is");
    refused([](auto& m) { m.fields = 1'000'000'000; }, MIDAIR_TOO_SMALL, "size is 9960");
    refused([](auto& m) { m.points = 0; }, MIDAIR_INVALID, "points is 0");
    refused([](auto& m) { m.points = kHuge; }, MIDAIR_INVALID, "points is");
    refused([](auto& m) { m.positions = nullptr; }, MIDAIR_INVALID, "positions is NULL");
    refused([](auto& m) { m.same_targets = 2; }, MIDAIR_INVALID, "same_targets is 2");
    refused([](auto& m) { m.reserved = 1; }, MIDAIR_INVALID, "reserved is 1");
    for (const double bad : {-1.0, 1e-5, 0.5, std::nan("")})
        refused([&](auto& m) { m.tolerance = bad; }, MIDAIR_INVALID, "rmsTolerance");
    for (const double bad : {-1.0, 1e-3, 4.0, std::nan("")})
        refused([&](auto& m) { m.largest_phase_step_rad = bad; }, MIDAIR_INVALID, "PhaseStep_rad");
    targets[2] = -1.0;
    refused([](auto&) {}, MIDAIR_INVALID, "point 2 of field 0 has the target -1");
    targets.assign(kPoints, 0.0);
    refused([](auto&) {}, MIDAIR_INVALID, "field 0 has only targets of 0");
    targets.assign(kPoints, 1.0);
    positions[3 * (5 * kPoints + 1)] = NAN;
    refused([](auto&) {}, MIDAIR_INVALID, "point 1 of field 5 is at (nan");
    positions[3 * (5 * kPoints + 1)] = 0.0;
    for (const std::uint8_t phase : phases)
        ASSERT_EQ(phase, 77) << "written";
    positions[1] = 1e7;
    refused([](auto&) {}, MIDAIR_REFUSED, "point 0 of field 0 is out of the array's reach");
    for (const auto& [name, value] : {std::pair{"maxPressure", "500"},
                                      {"maxAmplitude", "0.5"},
                                      {"earLimit", "120"},
                                      {"loudness", "0.5"},
                                      {"solver", "gs"},
                                      {"cycle", "4"}})
    {
        Opened other("board");
        ASSERT_EQ(midair_set(other.scene, name, value), MIDAIR_OK);
        const midair_many many = manyOf(positions);
        EXPECT_EQ(
            midair_solve_many(other.scene, &many, phases.data(), phases.size(), nullptr, nullptr),
            MIDAIR_REFUSED);
        EXPECT_NE(std::string(midair_last_error()).find(name), std::string::npos)
            << midair_last_error();
    }
    EXPECT_EQ(midair_solve_many(of.scene, nullptr, nullptr, 0, nullptr, nullptr), MIDAIR_INVALID);
    EXPECT_EQ(midair_solve_many(nullptr, nullptr, nullptr, 0, nullptr, nullptr), MIDAIR_CLOSED);
}

TEST(CSolveMany, LeavesDeadTransducersOut)
{
    Opened of("board");
    ASSERT_EQ(midair_set(of.scene, "dead", "17, 40-45"), MIDAIR_OK);
    const std::vector<double> positions = movingSquare();
    const midair_many many = manyOf(positions);
    std::vector<std::uint8_t> phases(kFields * 249);
    ASSERT_EQ(midair_solve_many(of.scene, &many, phases.data(), phases.size(), nullptr, nullptr),
              MIDAIR_OK)
        << midair_last_error();
    for (std::size_t k = 0; k < kFields; ++k)
        for (const std::size_t dead : {17U, 40U, 45U})
            EXPECT_EQ(phases[249 * k + dead], 0);
}
