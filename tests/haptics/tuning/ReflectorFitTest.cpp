// Fits of plates to sound that is made apart from the fit (PlateStage.h).
#include "haptics/tuning/ReflectorFit.h"

#include "haptics/base/InputError.h"
#include "tests/haptics/solvers/ScenePoints.h"
#include "tests/haptics/tuning/PlateStage.h"

#include <cmath>
#include <limits>
#include <string>

#include <gtest/gtest.h>

using namespace midair;
using namespace midair::haptics;

// Corrections pay to a quarter of a millimetre and a tenth of a degree.
TEST(ReflectorFit, FindsAPlateToWhatCorrectionsNeed)
{
    for (const int places : {1, 3, 4})
    {
        SCOPED_TRACE(places);
        PlateStage stage(places);
        const ReflectorFit fit = stage.fit(stage.readings());
        ASSERT_TRUE(fit.usable()) << fit.refusal;
        EXPECT_LT(std::fabs(fit.reflector.heightOf(stage.plate.position)), 0.25e-3);
        EXPECT_LT(tiltBetween(fit.reflector, stage.plate), 0.1);
        EXPECT_NEAR(fit.reflector.reflection, 0.8, 0.02);
        EXPECT_NEAR(fit.reflector.reflectionPhase_rad, 0.15, 0.2);
        EXPECT_TRUE(fit.isUseful()) << fit.text();
        EXPECT_GT(3e-3 * fit.reflector.accuracy_mm,
                  std::fabs(fit.reflector.heightOf(stage.plate.position)));
        EXPECT_LT(fit.after, 0.5 * fit.before);
    }
}

TEST(ReflectorFit, MakesCorrectedFieldsTrue)
{
    PlateStage stage;
    const ReflectorFit fit = stage.fit(stage.readings());
    ASSERT_TRUE(fit.usable()) << fit.refusal;
    const ControlPoints points = spherePoints(12, 0.015, {0.0, 0.0, 0.13});
    TransducerArray corrected = stage.tuned;
    corrected.reflectors = {fit.reflector};
    const double told = stage.errorOf(stage.tuned, points);
    EXPECT_GT(told, 0.05);
    EXPECT_LT(stage.errorOf(corrected, points), 0.35 * told);
}

TEST(ReflectorFit, OfOneThatIsNotThereIsRefused)
{
    PlateStage stage;
    const ReflectorFit fit = stage.fit(stage.readings(false));
    EXPECT_FALSE(fit.usable());
    EXPECT_NE(fit.refusal.find("no better with the reflector"), std::string::npos) << fit.refusal;
    EXPECT_NE(fit.text().find("refused"), std::string::npos);
}

TEST(ReflectorFit, KnowsThatNoiseMakesItLessSure)
{
    PlateStage stage(1);
    const ReflectorFit quiet = stage.fit(stage.readings());
    stage.noise = 0.2;
    const ReflectorFit noisy = stage.fit(stage.readings());
    ASSERT_TRUE(quiet.usable() && noisy.usable()) << quiet.refusal << noisy.refusal;
    EXPECT_GT(noisy.placeError_m, 1.5 * quiet.placeError_m);
    EXPECT_GT(noisy.tiltErrors_rad.norm(), 1.5 * quiet.tiltErrors_rad.norm());
}

TEST(ReflectorFit, LeavesOutWhatWasNotRead)
{
    PlateStage stage;
    TuningReadings readings = stage.readings();
    for (int row = 0; row < stage.plan.size(); row += 3)
        readings.values[row] = std::numeric_limits<double>::quiet_NaN();
    const ReflectorFit fit = stage.fit(readings);
    ASSERT_TRUE(fit.usable()) << fit.refusal;
    EXPECT_LT(std::fabs(fit.reflector.heightOf(stage.plate.position)), 0.4e-3);
    readings.values.setConstant(std::numeric_limits<double>::quiet_NaN());
    EXPECT_FALSE(stage.fit(readings).usable());
}

TEST(ReflectorFit, OfReadingsThatDoNotBelongIsRefusedByName)
{
    PlateStage stage;
    const TuningReadings readings = stage.readings();
    const auto says = [&](const TransducerArray& array,
                          const TuningPlan& plan,
                          const Reflector& guess,
                          const ReflectorFitOptions& options) -> std::string
    {
        try
        {
            fitReflector(array, plan, readings, guess, options);
        }
        catch (const base::InputError& error)
        {
            return error.what();
        }
        return "";
    };
    TuningPlan levels = stage.plan;
    levels.method = TuningMethod::LEVELS;
    EXPECT_NE(says(stage.tuned, levels, stage.guess, {}).find("phases"), std::string::npos);
    EXPECT_NE(
        says(TransducerArray::octagonalPrism(), stage.plan, stage.guess, {}).find("transducers"),
        std::string::npos);
    Reflector bent = stage.guess;
    bent.reflection = 2.0;
    EXPECT_NE(says(stage.tuned, stage.plan, bent, {}).find("reflection"), std::string::npos);
    ReflectorFitOptions far;
    far.search_m = 1.0;
    EXPECT_NE(says(stage.tuned, stage.plan, stage.guess, far).find("search"), std::string::npos);
    far.search_m = std::numeric_limits<double>::quiet_NaN();
    EXPECT_NE(says(stage.tuned, stage.plan, stage.guess, far).find("search"), std::string::npos);
    TransducerArray full = stage.tuned;
    full.reflectors.assign(kMostReflectors, stage.guess);
    EXPECT_NE(says(full, stage.plan, stage.guess, {}).find("reflectors"), std::string::npos);
}
