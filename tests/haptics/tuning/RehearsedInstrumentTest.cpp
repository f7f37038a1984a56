#include "haptics/base/DutyLaw.h"
#include "haptics/base/InputError.h"
#include "haptics/base/Units.h"
#include "haptics/propagation/ReferencePropagation.h"
#include "haptics/tuning/MicrophoneFit.h"
#include "tests/haptics/tuning/Rehearsal.h"

#include <cmath>

#include <gtest/gtest.h>

using namespace midair;
using namespace midair::haptics;

TEST(RehearsedInstrument, hides_what_it_is_asked_to)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    const TuningPlan plan = planFor(array, TuningMethod::SINGLE, Eigen::Vector3d::Zero());
    const RehearsedInstrument instrument(array, plan, {});
    double squares = 0.0, reversed = 0.0;
    const TransducerArray& truth = instrument.truth();
    for (int i = 0; i < array.size(); ++i)
    {
        const bool isReversed = instrument.reversed()[static_cast<std::size_t>(i)];
        const double phase = truth.phaseOffset_rad[i] - (isReversed ? base::kPi : 0.0);
        squares += phase * phase;
        reversed += isReversed ? 1.0 : 0.0;
        if (truth.gain[i] > 0.0)
        {
            EXPECT_NEAR(truth.gain[i], std::cos(phase), 0.25) << "5 % of its own, 5 times";
        }
    }
    EXPECT_NEAR(base::toDegrees(std::sqrt(squares / array.size())), 15.0, 1.0);
    EXPECT_NEAR(reversed / array.size(), 0.5, 0.03);
    EXPECT_NEAR(double(truth.dead.size()) / array.size(), 0.01, 0.005);
    EXPECT_LT((instrument.places().col(0)).norm(), 8e-3);
}

TEST(RehearsedInstrument, says_what_the_reference_says)
{
    const TransducerArray array = TransducerArray::singleBoard();
    TuningPlanOptions options;
    options.places = placesBeforeBoard(1);
    options.dutyLevel = 100;
    const TuningPlan plan = makeTuningPlan(array, options);
    RehearsalOptions hidden;
    hidden.noise_dB = hidden.reflections_dB = -300.0;
    hidden.sensitivity = 0.01;
    RehearsedInstrument instrument(array, plan, hidden);
    Medium medium;
    medium.temperature_C = 21.0;
    const Eigen::MatrixXcd G =
        referencePropagationMatrix(instrument.places(), instrument.truth(), medium);
    const int row = 16 + 77; // the silent ones come first
    const std::complex<double> ratio = instrument.reading(row) / instrument.reading(row + 1);
    EXPECT_LT(std::abs(ratio - G(0, 77) / G(0, 78)), 1e-6);
    EXPECT_NEAR(std::abs(instrument.reading(row)),
                0.01 * base::dutyAmplitude(100) * std::abs(G(0, 77)),
                1e-9);
    EXPECT_LT(std::abs(instrument.reading(0)), 1e-9);
}

TEST(RehearsedInstrument, gives_the_same_reading_of_a_row_again)
{
    const TransducerArray array = TransducerArray::singleBoard();
    const TuningPlan plan = planFor(array, TuningMethod::SINGLE, placesBeforeBoard(2));
    RehearsedInstrument instrument(array, plan, {});
    const std::complex<double> first = instrument.reading(50);
    EXPECT_NE(instrument.reading(plan.size() - 3), first);
    EXPECT_EQ(instrument.reading(50), first);
    RehearsalOptions wrong;
    wrong.dead = 1.5;
    EXPECT_THROW(RehearsedInstrument(array, plan, wrong), base::InputError);
    EXPECT_THROW(RehearsedInstrument(TransducerArray::octagonalPrism(), plan, {}),
                 base::InputError);
}

TEST(PlaceSearch, finds_a_place_exactly_where_phases_are_exact)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    HeardPhases heard;
    heard.positions = array.positions;
    heard.wavenumber = 732.0;
    const Eigen::Vector3d place(0.011, -0.004, 0.007);
    heard.phase_rad.resize(array.size());
    for (int i = 0; i < array.size(); ++i)
        heard.phase_rad[i] = wrappedToHalfTurn(
            0.4 - 732.0 * (place - array.positions.col(i)).norm()); // polarity is lost
    const FoundPlace found = findPlace(heard, place + Eigen::Vector3d(3e-3, -3e-3, 2.5e-3), 6e-3);
    EXPECT_LT((found.place - place).norm(), 1e-6);
    EXPECT_NEAR(found.agreement, 1.0, 1e-6);
    EXPECT_NEAR(wrappedToHalfTurn(found.phase_rad - 0.4), 0.0, 1e-4);
}

TEST(PlaceSearch, wraps_to_half_a_turn)
{
    EXPECT_NEAR(wrappedToHalfTurn(3.2), 3.2 - base::kPi, 1e-12);
    EXPECT_NEAR(wrappedToHalfTurn(-1.5), -1.5, 1e-12);
    EXPECT_NEAR(wrappedToHalfTurn(7 * base::kPi + 0.1), 0.1, 1e-12);
}
