#include "haptics/tuning/FocusCheck.h"

#include "haptics/base/InputError.h"
#include "tests/haptics/tuning/Rehearsal.h"

#include <gtest/gtest.h>

using namespace midair;
using namespace midair::haptics;

namespace
{

/// A board with hidden errors, and the foci that \a tuned makes of it.
FocusCheck checked(const TransducerArray& tuned, const RehearsalOptions& hidden)
{
    TuningPlanOptions options;
    options.method = TuningMethod::FOCUS;
    options.places = placesBeforeBoard(1);
    options.temperature_C = hidden.temperature_C;
    const TuningPlan plan = makeTuningPlan(tuned, options);
    RehearsedInstrument instrument(TransducerArray::singleBoard(), plan, hidden);
    return checkFocus(tuned, plan, readingsOf(instrument, plan, &tuned));
}

/// The board as the rehearsal of \a hidden has it.
TransducerArray truthOf(const RehearsalOptions& hidden)
{
    const TransducerArray board = TransducerArray::singleBoard();
    const TuningPlan plan = planFor(board, TuningMethod::SINGLE, placesBeforeBoard(1));
    return RehearsedInstrument(board, plan, hidden).truth();
}

} // namespace

TEST(FocusCheck, passes_a_tuned_array_and_finds_its_microphone)
{
    RehearsalOptions hidden;
    hidden.reflections_dB = -300.0;
    hidden.displacement_m = 2e-3;
    const FocusCheck check = checked(truthOf(hidden), hidden);
    ASSERT_EQ(check.places.size(), 1u) << check.refusal;
    const FocusFigures& at = check.places.front();
    EXPECT_NEAR(at.ratio, 1.0, 0.02);
    EXPECT_NEAR((at.place - placesBeforeBoard(1)).norm(), 2e-3, 0.3e-3);
    // A board of 180 x 140 mm, 150 mm away: about the wavelength and more.
    EXPECT_GT(at.width_m.x(), 8e-3);
    EXPECT_LT(at.width_m.y(), 14e-3);
    EXPECT_NEAR(at.width_m.x(), at.predictedWidth_m.x(), 0.5e-3);
    EXPECT_NEAR(at.width_m.y(), at.predictedWidth_m.y(), 0.5e-3);
    EXPECT_TRUE(check.passes());
}

TEST(FocusCheck, fails_an_array_that_is_not_tuned)
{
    const RehearsalOptions hidden;
    const FocusCheck check = checked(TransducerArray::singleBoard(), hidden);
    ASSERT_EQ(check.places.size(), 1u) << check.refusal;
    EXPECT_LT(check.places.front().ratio, 0.5);
    EXPECT_FALSE(check.passes());
}

// Phases with 30 degrees of error leave e^{-s^2/2} = 0.87 of the focus.
TEST(FocusCheck, measures_what_phase_errors_cost)
{
    RehearsalOptions hidden;
    hidden.reflections_dB = -300.0;
    hidden.dead = 0.0;
    TransducerArray wrong = truthOf(hidden);
    std::mt19937 random(4);
    std::normal_distribution<double> error(0.0, 0.5236);
    for (double& phase : wrong.phaseOffset_rad)
        phase += error(random);
    const FocusCheck check = checked(wrong, hidden);
    ASSERT_EQ(check.places.size(), 1u) << check.refusal;
    EXPECT_NEAR(check.places.front().ratio, 0.87, 0.05);
    EXPECT_FALSE(check.passes());
}

TEST(FocusCheck, refuses_silence_and_other_plans)
{
    const TransducerArray board = TransducerArray::singleBoard();
    const TuningPlan plan = planFor(board, TuningMethod::FOCUS, placesBeforeBoard(1));
    TuningReadings silent;
    silent.areLevels = true;
    silent.values.setZero(plan.size());
    EXPECT_NE(checkFocus(board, plan, silent).refusal.find("hears no focus at place 0"),
              std::string::npos);
    EXPECT_THROW(
        checkFocus(board, planFor(board, TuningMethod::SINGLE, placesBeforeBoard(1)), silent),
        base::InputError);
}
