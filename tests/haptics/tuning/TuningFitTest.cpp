// Fits of rehearsals, whose instrument is written apart from the fit, against what they hide. The
// bars are for detuned transducers of 15 degrees rms, half of them reversed, 1 % dead, a microphone
// 2 mm from its place, air 1 K warmer, noise at -40 dB, reflections at -20 dB.
#include "haptics/tuning/TuningFit.h"

#include "haptics/base/InputError.h"
#include "haptics/base/Units.h"
#include "tests/haptics/tuning/Rehearsal.h"
#include "tests/haptics/tuning/TuningAccuracy.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

using namespace midair;
using namespace midair::haptics;

namespace
{

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// A rehearsal from the plan to the fit.
struct Tuned
{
    TransducerArray array;
    TuningPlan plan;
    RehearsedInstrument instrument;
    TuningReadings readings;

    Tuned(const TransducerArray& of,
          TuningMethod method,
          const Eigen::Matrix3Xd& places,
          const RehearsalOptions& hidden = {}) :
        array(of),
        plan(planFor(of, method, places)),
        instrument(of, plan, hidden),
        readings(readingsOf(instrument, plan))
    {
    }

    TuningFit fit(const TuningFitOptions& options = {}) const
    {
        return fitTuning(array, plan, readings, options);
    }
};

TransducerArray board()
{
    return TransducerArray::singleBoard();
}

void expectGood(const TuningFit& fit, const Tuned& tuned, double phase_deg, double focus)
{
    ASSERT_TRUE(fit.usable()) << fit.refusal;
    const TuningAccuracy accuracy = accuracyOf(fit, tuned.instrument);
    EXPECT_LE(base::toDegrees(accuracy.phaseError_rad), phase_deg);
    EXPECT_EQ(accuracy.reversedWrong, 0);
    EXPECT_EQ(accuracy.deadFound, accuracy.dead);
    EXPECT_EQ(accuracy.deadWrong, 0);
    EXPECT_GE(accuracy.focus, focus);
    EXPECT_LE(accuracy.gainError, 0.1);
}

} // namespace

TEST(TuningFit, of_a_board_reaches_its_bars_with_each_method)
{
    for (const TuningMethod method :
         {TuningMethod::SINGLE, TuningMethod::HADAMARD, TuningMethod::LEVELS})
    {
        SCOPED_TRACE(tuningMethodName(method));
        RehearsalOptions hidden;
        hidden.seed = 3;
        hidden.dead = 0.02;
        const Tuned one(board(), method, placesBeforeBoard(1), hidden);
        expectGood(one.fit(), one, 5.0, 0.99);
        const Tuned four(board(), method, placesBeforeBoard(4), hidden);
        expectGood(four.fit(), four, 3.0, 0.997);
    }
}

TEST(TuningFit, of_the_octagon_finds_the_microphone_from_5_mm_off)
{
    RehearsalOptions hidden;
    hidden.displacement_m = 5e-3;
    const Tuned tuned(TransducerArray::octagonalPrism(),
                      TuningMethod::SINGLE,
                      Eigen::Vector3d(0, 0.01, 0),
                      hidden);
    const TuningFit fit = tuned.fit();
    expectGood(fit, tuned, 5.0, 0.99);
    const TuningAccuracy accuracy = accuracyOf(fit, tuned.instrument);
    EXPECT_LT(accuracy.placeErrors_m.col(0).norm(), 0.1e-3);
    // 21 C where 20 were assumed.
    EXPECT_NEAR(fit.microphone.soundSpeed_m_s, 343.80, 0.4);
    EXPECT_LT(fit.microphone.soundSpeedError_m_s, 0.4);
    EXPECT_NEAR(base::toDegrees(fit.phaseSpread_rad), 15.0, 1.5);
    EXPECT_LT(fit.focusBefore, 0.1) << "half of them are reversed";
}

// Without anything to find, nothing is found.
TEST(TuningFit, of_a_perfect_array_is_a_perfect_array)
{
    RehearsalOptions hidden;
    hidden.detuning_Hz = hidden.reversed = hidden.dead = hidden.gainSpread = hidden.placeError_m =
        0;
    hidden.temperature_C = 20.0;
    hidden.noise_dB = hidden.reflections_dB = -300.0;
    for (const TuningMethod method :
         {TuningMethod::SINGLE, TuningMethod::HADAMARD, TuningMethod::LEVELS})
    {
        const Tuned tuned(board(), method, placesBeforeBoard(2), hidden);
        const TuningFit fit = tuned.fit();
        ASSERT_TRUE(fit.usable()) << fit.refusal;
        EXPECT_LT(fit.array.phaseOffset_rad.cwiseAbs().maxCoeff(), 1e-4);
        EXPECT_LT((fit.array.gain.array() - 1.0).abs().maxCoeff(), 1e-4);
        EXPECT_NEAR(fit.focusBefore, 1.0, 1e-6);
        EXPECT_TRUE(fit.notes.empty());
    }
}

// Standard errors that are right hold in two of three cases, and three of them nearly always.
TEST(TuningFit, knows_how_well_it_knows_the_microphone)
{
    int within = 0, all = 0;
    for (std::uint32_t seed = 1; seed <= 12; ++seed)
    {
        RehearsalOptions hidden;
        hidden.seed = seed;
        hidden.reflections_dB = -300.0;
        const Tuned tuned(board(), TuningMethod::SINGLE, placesBeforeBoard(1), hidden);
        const TuningFit fit = tuned.fit();
        ASSERT_TRUE(fit.usable()) << fit.refusal;
        const Eigen::Vector3d error =
            fit.microphone.places.col(0) - tuned.instrument.places().col(0);
        for (int axis = 0; axis < 3; ++axis, ++all)
        {
            within += std::abs(error[axis]) <= fit.microphone.placeErrors(axis, 0) ? 1 : 0;
            EXPECT_LE(std::abs(error[axis]), 3.5 * fit.microphone.placeErrors(axis, 0));
        }
    }
    EXPECT_GT(within, all / 3);
    EXPECT_LT(within, all);
}

TEST(TuningFit, uses_what_there_is_of_incomplete_readings)
{
    Tuned single(board(), TuningMethod::SINGLE, placesBeforeBoard(2));
    int far = -1; // rows of transducer 100 at both places
    for (int row = 0; row < single.plan.size(); ++row)
        if (single.plan.rows[static_cast<std::size_t>(row)].element == 100)
            single.readings.values[far = row] = {kNaN, kNaN};
    single.readings.values[30] = {kNaN, kNaN};
    const TuningFit fit = single.fit();
    ASSERT_TRUE(fit.usable()) << fit.refusal << far;
    EXPECT_EQ(fit.of(TransducerState::NOT_MEASURED), std::vector<int>{100});
    EXPECT_EQ(fit.array.gain[100], 1.0);
    EXPECT_NE(fit.text().find("unmeasured  1, which keep what the array's file says: 100\n"),
              std::string::npos)
        << fit.text();

    // Six columns of a matrix of order 256 are unused by 249 transducers: three rows can be
    // missing.
    Tuned hadamard(board(), TuningMethod::HADAMARD, placesBeforeBoard(1));
    const TuningFit whole = hadamard.fit();
    for (const int row : {17, 100, 255})
        hadamard.readings.values[row] = {kNaN, kNaN};
    const TuningFit filled = hadamard.fit();
    ASSERT_TRUE(filled.usable()) << filled.refusal;
    EXPECT_LT((filled.array.gain - whole.array.gain).cwiseAbs().maxCoeff(), 0.05);
    EXPECT_EQ(filled.notes.back(), "3 rows of place 0 without a reading follow from the others");
    hadamard.readings.values[3] = {kNaN, kNaN};
    EXPECT_EQ(hadamard.fit().refusal,
              "4 of the 256 rows of place 0 have no reading (3, 17, 100, 255); at most 3 can be "
              "filled in, so measure these again");

    Tuned levels(board(), TuningMethod::LEVELS, placesBeforeBoard(1));
    for (int row = 60; row < levels.plan.size(); row += 4)
        levels.readings.values[row + row % 3] = {kNaN, kNaN};
    expectGood(levels.fit(), levels, 5.5, 0.99);
}

TEST(TuningFit, keeps_a_leak_of_the_drive_apart)
{
    for (const TuningMethod method : {TuningMethod::SINGLE, TuningMethod::HADAMARD})
    {
        Tuned tuned(board(), method, placesBeforeBoard(1));
        tuned.readings.values.array() += std::complex<double>(30.0, -20.0);
        expectGood(tuned.fit(), tuned, 5.0, 0.99);
    }
}

TEST(TuningFit, refuses_what_a_clipping_or_deaf_microphone_says)
{
    for (const TuningMethod method :
         {TuningMethod::SINGLE, TuningMethod::HADAMARD, TuningMethod::LEVELS})
    {
        SCOPED_TRACE(tuningMethodName(method));
        RehearsalOptions hidden;
        const Tuned fine(board(), method, placesBeforeBoard(1), hidden);
        hidden.clip = 0.55 * fine.readings.values.cwiseAbs().maxCoeff();
        const Tuned clipped(board(), method, placesBeforeBoard(1), hidden);
        EXPECT_NE(clipped.fit().refusal.find("clip"), std::string::npos) << clipped.fit().text();
        TuningFitOptions known;
        known.clip = fine.readings.values.cwiseAbs().maxCoeff();
        EXPECT_NE(fine.fit(known).refusal.find("the microphone clips: readings of "),
                  std::string::npos);

        hidden.clip = 0.0;
        hidden.noise_dB = 40.0;
        const Tuned deaf(board(), method, placesBeforeBoard(1), hidden);
        EXPECT_FALSE(deaf.fit().usable());
        EXPECT_NE(deaf.fit().text().find("refused     "), std::string::npos);
        if (method == TuningMethod::SINGLE)
        {
            EXPECT_NE(deaf.fit().refusal.find("the microphone hears nothing at place 0"),
                      std::string::npos);
        }
        Tuned silent(board(), method, placesBeforeBoard(1));
        silent.readings.values.setZero();
        EXPECT_NE(silent.fit().refusal.find("hears nothing"), std::string::npos);
    }
}

TEST(TuningFit, refuses_phases_that_agree_nowhere)
{
    RehearsalOptions hidden;
    hidden.displacement_m = 30e-3;
    const Tuned elsewhere(board(), TuningMethod::SINGLE, placesBeforeBoard(1), hidden);
    EXPECT_NE(elsewhere.fit().refusal.find("spread by more than 45 degrees"), std::string::npos)
        << elsewhere.fit().text();
    // Phases by chance, thirty times: none is taken for a tuning.
    Tuned chance(board(), TuningMethod::SINGLE, placesBeforeBoard(1));
    std::mt19937 random(9);
    std::uniform_real_distribution<double> turn(0.0, 6.2831853);
    for (int trial = 0; trial < 30; ++trial)
    {
        for (auto& value : chance.readings.values)
            value = std::polar(std::abs(value), turn(random));
        EXPECT_FALSE(chance.fit().usable());
    }
}

TEST(TuningFit, tells_an_instrument_whose_phases_run_the_other_way)
{
    Tuned tuned(board(), TuningMethod::SINGLE, placesBeforeBoard(1));
    tuned.readings.values = tuned.readings.values.conjugate().eval();
    EXPECT_NE(tuned.fit().refusal.find("change the sign of im"), std::string::npos)
        << tuned.fit().text();
}

TEST(TuningFit, says_what_one_unknown_place_cannot_know)
{
    const Tuned tuned(board(), TuningMethod::SINGLE, placesBeforeBoard(1));
    const std::string text = tuned.fit().text();
    EXPECT_NE(text.find("phases are known up to a shift of the whole field"), std::string::npos);
    EXPECT_NE(text.find("residual    not known from one place"), std::string::npos);
}

TEST(TuningFit, is_an_array_file_that_comes_back)
{
    const Tuned tuned(board(), TuningMethod::SINGLE, placesBeforeBoard(1));
    const TuningFit fit = tuned.fit();
    ASSERT_TRUE(fit.usable());
    const TransducerArray read = TransducerArray::fromJson(fit.array.toJson(), "tuned");
    EXPECT_LT((read.phaseOffset_rad - fit.array.phaseOffset_rad).cwiseAbs().maxCoeff(), 1e-12);
    EXPECT_EQ(read.dead, fit.array.dead);
}

TEST(TuningFit, wants_the_plan_and_the_array_to_belong_together)
{
    const Tuned tuned(board(), TuningMethod::SINGLE, placesBeforeBoard(1));
    EXPECT_THROW(fitTuning(TransducerArray::octagonalPrism(), tuned.plan, tuned.readings),
                 base::InputError);
    TuningFitOptions options;
    options.deadGain = 2.0;
    EXPECT_THROW(tuned.fit(options), base::InputError);
    TuningPlan foci = tuned.plan;
    foci.method = TuningMethod::FOCUS;
    EXPECT_THROW(fitTuning(tuned.array, foci, tuned.readings), base::InputError);
}
