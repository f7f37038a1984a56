// What a midair_solver takes and refuses, and what goes on from field to field.
#include "tests/engine-bridge/c/Star.h"

#include <cmath>

TEST(CSolver, FindsAFocusAndGoesOnFromIt)
{
    Opened of;
    midair_solver* solver = nullptr;
    ASSERT_EQ(midair_solver_open(of.scene, &solver), MIDAIR_OK) << midair_last_error();
    std::size_t m = 0;
    ASSERT_EQ(midair_array_size(of.array, &m), MIDAIR_OK);
    EXPECT_EQ(m, 3984U);
    std::vector<float> q(2 * m);
    double positions[] = {0.0, 0.0, 0.0, 0.02, 0.0, 0.0};
    const double targets[] = {1.0, 0.5};
    double rms = 1.0;
    EXPECT_EQ(midair_solver_figure(solver, "rms", &rms), MIDAIR_NOT_YET);
    for (int k = 0; k < 3; ++k)
    {
        positions[0] = 1e-4 * k;
        ASSERT_EQ(midair_solver_solve(solver, positions, targets, 2, 0, q.data(), m), MIDAIR_OK);
        ASSERT_EQ(midair_solver_figure(solver, "rms", &rms), MIDAIR_OK);
        EXPECT_LT(rms, 0.02);
    }
    EXPECT_EQ(midair_solver_solve(solver, positions, targets, 2, 0, q.data(), m - 1),
              MIDAIR_TOO_SMALL);
    EXPECT_EQ(midair_solver_solve(solver, positions, targets, 0, 0, q.data(), m), MIDAIR_INVALID);
    positions[4] = NAN;
    EXPECT_EQ(midair_solver_solve(solver, positions, targets, 2, 0, q.data(), m), MIDAIR_INVALID);
    EXPECT_NE(std::string(midair_last_error()).find("number 2 of the 2. is nan"), std::string::npos)
        << midair_last_error();
    EXPECT_EQ(midair_solver_close(solver), MIDAIR_OK);
    EXPECT_EQ(midair_solver_solve(solver, positions, targets, 2, 0, q.data(), m), MIDAIR_CLOSED);
}

namespace
{

/// Activations of one focus at \a x_m by a solver that stays open.
std::vector<float> focusAt(midair_solver* solver, std::size_t m, double x_m, midair_status expected)
{
    const double position[] = {x_m, 0.0, 0.0};
    const double target = 1.0;
    std::vector<float> q(2 * m);
    EXPECT_EQ(midair_solver_solve(solver, position, &target, 1, 0, q.data(), m), expected)
        << midair_last_error();
    return q;
}

} // namespace

// What listens is kept from field to field, and is that of each field's own array, air and ears.
TEST(CSolver, KeepsItsFieldWithinTheMotionTolerance)
{
    Opened of;
    std::size_t m = 0;
    ASSERT_EQ(midair_array_size(of.array, &m), MIDAIR_OK);
    for (const char* tolerance : {"1e-5", "0.5"})
    {
        ASSERT_EQ(midair_set(of.scene, "motionTolerance", tolerance), MIDAIR_OK);
        midair_solver* solver = nullptr;
        ASSERT_EQ(midair_solver_open(of.scene, &solver), MIDAIR_OK) << midair_last_error();
        const auto first = focusAt(solver, m, 0.0, MIDAIR_OK);
        const auto moved = focusAt(solver, m, 2e-3, MIDAIR_OK); // a quarter of a wavelength
        EXPECT_EQ(first == moved, std::string(tolerance) == "0.5") << tolerance;
        EXPECT_EQ(midair_solver_close(solver), MIDAIR_OK);
    }
}

TEST(CSolver, KnowsDeadTransducersAndItsOwnLimitOfPoints)
{
    Opened of;
    std::size_t m = 0;
    ASSERT_EQ(midair_array_size(of.array, &m), MIDAIR_OK);
    ASSERT_EQ(midair_set(of.scene, "dead", "17, 400-410"), MIDAIR_OK);
    ASSERT_EQ(midair_set(of.scene, "maxPoints", "1"), MIDAIR_OK);
    midair_solver* solver = nullptr;
    ASSERT_EQ(midair_solver_open(of.scene, &solver), MIDAIR_OK) << midair_last_error();
    const auto q = focusAt(solver, m, 0.0, MIDAIR_OK);
    for (const std::size_t dead : {17U, 400U, 410U})
        EXPECT_EQ(std::hypot(q[2 * dead], q[2 * dead + 1]), 0.0F) << dead;
    EXPECT_GT(std::hypot(q[2 * 18], q[2 * 18 + 1]), 0.5F);
    const double two[] = {0.0, 0.0, 0.0, 0.02, 0.0, 0.0};
    const double targets[] = {1.0, 1.0};
    std::vector<float> other(2 * m);
    EXPECT_EQ(midair_solver_solve(solver, two, targets, 2, 0, other.data(), m), MIDAIR_INVALID);
    EXPECT_STREQ(midair_last_error(), "count is 2; maxPoints is 1");
    EXPECT_EQ(midair_solver_close(solver), MIDAIR_OK);
}

// Each setting of a field has its effect on a solver, or is refused by name.
TEST(CSolver, RefusesWhatIsOfNoUseToIt)
{
    for (const auto& [name, value] : {std::pair{"cycle", "4"},
                                      {"cycleSteps", "2"},
                                      {"even", "7"},
                                      {"subsets", "2"},
                                      {"denseOutlines", "false"},
                                      {"monitorInterval", "1"},
                                      {"maxPressure", "500"},
                                      {"maxAmplitude", "0.5"},
                                      {"earLimit", "120"}})
    {
        Opened of;
        ASSERT_EQ(midair_set(of.scene, name, value), MIDAIR_OK) << name;
        midair_solver* solver = nullptr;
        EXPECT_EQ(midair_solver_open(of.scene, &solver), MIDAIR_REFUSED) << name;
        EXPECT_NE(std::string(midair_last_error()).find(name), std::string::npos)
            << midair_last_error();
    }
}

TEST(CSolver, TakesTheOtherSettings)
{
    std::size_t m = 0;
    std::vector<float> plain;
    for (const auto& [name, value] : {std::pair{"", ""},
                                      {"temperature", "35"},
                                      {"humidity", "0.1"},
                                      {"airPressure", "80000"},
                                      {"solver", "gs"},
                                      {"loudness", "0.5"},
                                      {"weak", "17:0.5"},
                                      {"phaseOnly", "false"}})
    {
        Opened of("board");
        ASSERT_EQ(midair_array_size(of.array, &m), MIDAIR_OK);
        if (*name)
        {
            ASSERT_EQ(midair_set(of.scene, name, value), MIDAIR_OK) << midair_last_error();
        }
        midair_solver* solver = nullptr;
        ASSERT_EQ(midair_solver_open(of.scene, &solver), MIDAIR_OK) << midair_last_error();
        const double positions[] = {0.0, 0.0, 0.15, 0.02, 0.0, 0.14, -0.01, 0.02, 0.13};
        const double targets[] = {1.0, 0.7, 0.4};
        std::vector<float> q(2 * m);
        ASSERT_EQ(midair_solver_solve(solver, positions, targets, 3, 0, q.data(), m), MIDAIR_OK);
        if (plain.empty())
            plain = q;
        else
            EXPECT_NE(q, plain) << name << " has no effect";
        EXPECT_EQ(midair_solver_close(solver), MIDAIR_OK);
    }
}
