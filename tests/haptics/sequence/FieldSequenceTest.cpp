#include "haptics/sequence/FieldSequence.h"

#include "haptics/sequence/FieldOrder.h"
#include "tests/haptics/solvers/ScenePoints.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace midair::haptics
{
namespace
{

TEST(FieldSequence, PointsAndPressuresArePlayingOrderWithoutTheStepsBetween)
{
    const TransducerArray array = TransducerArray::singleBoard();
    FieldSequence sequence;
    for (int k = 0; k < 3; ++k)
        sequence.fields.push_back(Eigen::VectorXcf::Constant(
            array.size(), std::polar(1.0f, 0.5f * static_cast<float>(k))));
    sequence.parts.resize(3);
    sequence.parts[0] = spherePoints(2, 0.01, {0, 0, 0.1});
    sequence.parts[2] = spherePoints(3, 0.01, {0, 0, 0.15});
    sequence.parts[2].absolute = sequence.parts[0].absolute = true;
    const ControlPoints points = sequence.points();
    ASSERT_EQ(points.size(), 5);
    EXPECT_TRUE(points.absolute);
    EXPECT_EQ(points.positions.rightCols(3), sequence.parts[2].positions);
    sequence.fields[2] *= 0.5f;
    const Eigen::VectorXf before_Pa = achievedPressure(sequence, array, Medium(), 1);
    sequence.fields[2] *= 0.5f;
    const Eigen::VectorXf after_Pa = achievedPressure(sequence, array, Medium(), 1);
    EXPECT_TRUE(after_Pa.head(2).isApprox(before_Pa.head(2)));
    EXPECT_TRUE(after_Pa.tail(3).isApprox(0.5f * before_Pa.tail(3), 1e-5f));
    EXPECT_EQ(FieldSequence().points().size(), 0);
}

TEST(FieldSequence, StepsAreThoseOfTheWholeCycleAtItsRate)
{
    FieldSequence sequence;
    for (const float phase : {0.0f, 0.3f, 0.6f})
        sequence.fields.push_back(Eigen::VectorXcf::Constant(10, std::polar(1.0f, phase)));
    rateSteps(sequence);
    EXPECT_NEAR(sequence.report.meanPhaseStep_rad, (0.3 + 0.3 + 0.6) / 3.0, 1e-6);
    EXPECT_EQ(sequence.report.driveChange, cycleSteps(sequence.fields).driveChange);
    const double audible = sequence.report.audibleChange;
    EXPECT_GT(audible, 0.0);
    sequence.modulation.fieldRate_Hz = 40000.0;
    rateSteps(sequence);
    EXPECT_LT(sequence.report.audibleChange, audible);
    sequence.fields.resize(1);
    rateSteps(sequence);
    EXPECT_EQ(sequence.report.driveChange, 0.0);
}

TEST(FieldSequence, AHeldFieldGoesOnFromTheOneBefore)
{
    FieldSequence sequence;
    const Eigen::VectorXcf last = Eigen::VectorXcf::Constant(10, std::polar(1.0f, 1.0f));
    sequence.fields = {Eigen::VectorXcf::Constant(10, std::polar(1.0f, 2.5f))};
    DriveResolution drive;
    continueFrom(last, 1000.0, drive, sequence);
    // A common phase can't be felt: nothing has changed but for the rounding to levels.
    EXPECT_LT(sequence.report.meanPhaseStep_rad, M_PI / 256 + 1e-6);
    EXPECT_LT(sequence.report.driveChange, 1e-3);
    const SolveReport before = sequence.report;
    continueFrom(Eigen::VectorXcf::Ones(4), 1000.0, drive, sequence);
    EXPECT_EQ(sequence.report.driveChange, before.driveChange) << "another array's";
}

TEST(FieldSequence, AHeldFieldIsASwitchFromTheOneBefore)
{
    FieldSequence sequence;
    const Eigen::VectorXcf last = Eigen::VectorXcf::Ones(4);
    const auto share = [&](const Eigen::VectorXcf& q, double rate_Hz)
    {
        sequence.fields = {q};
        sequence.report.ringingShare = 1.0;
        rateSwitch(last, rate_Hz, 190e-6, sequence);
        return sequence.report.ringingShare;
    };
    EXPECT_EQ(share(last, 1000.0), 1.0);
    // Fields with the overlap rho lose (1 - rho)(tau/T)(1 - e^{-T/tau})^2.
    Eigen::VectorXcf other = last;
    other.tail(2) *= -1.0f;
    EXPECT_NEAR(share(other, 1000.0), 1.0 - 0.19 * std::pow(1.0 - std::exp(-1.0 / 0.19), 2), 1e-6);
    EXPECT_NEAR(share(-last, 200.0), 1.0 - 2.0 * 0.038, 1e-6);
    EXPECT_EQ(share(0.5f * last, 1000.0), 1.0) << "what rings on is no more than asked for";
    EXPECT_EQ(share(Eigen::VectorXcf::Zero(4), 1000.0), 1.0);
    EXPECT_EQ(share(Eigen::VectorXcf::Ones(3), 1000.0), 1.0) << "another array's";
    sequence.fields.resize(2, other);
    sequence.report.ringingShare = 0.5;
    rateSwitch(last, 1000.0, 190e-6, sequence);
    EXPECT_EQ(sequence.report.ringingShare, 0.5) << "fields in turn know it themselves";
}

TEST(FieldSequence, RingingCostsWhatIsSwitchedAndModulated)
{
    FieldSequence sequence;
    sequence.fields = {Eigen::VectorXcf::Ones(4), Eigen::VectorXcf::Ones(4)};
    sequence.fields[1].tail(2) *= -1.0f; // unrelated
    rateRinging(sequence, 190e-6);
    EXPECT_NEAR(sequence.report.ringingShare, 0.81, 0.003);
    EXPECT_EQ(sequence.report.ringingModulation, 1.0);
    sequence.modulation.fieldRate_Hz = 500.0;
    rateRinging(sequence, 190e-6);
    EXPECT_NEAR(sequence.report.ringingShare, 0.905, 0.003);
    rateRinging(sequence, 0.0);
    EXPECT_EQ(sequence.report.ringingShare, 1.0);
    // A modulation that never repeats with the fields takes as much as one that does.
    sequence.modulation.amplitudeRate_Hz = 50.0;
    rateRinging(sequence, 190e-6);
    const double repeated = sequence.report.ringingShare;
    EXPECT_LT(repeated, 0.92);
    sequence.modulation.amplitudeRate_Hz = 50.0 + 1e-3 * M_PI;
    rateRinging(sequence, 190e-6);
    EXPECT_NEAR(sequence.report.ringingShare, repeated, 0.003);

    sequence.fields.resize(1);
    sequence.modulation.amplitudeRate_Hz = 0.0;
    rateRinging(sequence, 190e-6);
    EXPECT_EQ(sequence.report.ringingShare, 1.0);
    sequence.modulation.fieldRate_Hz = 4000.0;
    sequence.modulation.amplitudeRate_Hz = 200.0;
    rateRinging(sequence, 190e-6);
    // |cos| swings at twice this rate in its kinks, too; its power's line loses about a tenth.
    EXPECT_GT(sequence.report.ringingModulation, 0.85);
    EXPECT_LT(sequence.report.ringingModulation, 0.99);
    EXPECT_GT(sequence.report.ringingShare, 0.9);
    EXPECT_LT(sequence.report.ringingShare, 1.0);
}

TEST(SolveReport, FiguresAreWrittenByNameOnce)
{
    SolveReport report;
    report.rms = 0.25;
    report.points = 7;
    const auto figures = figuresOf(report);
    EXPECT_EQ(figures.size(), kFigures.size());
    report.surface.samples = 3;
    report.surface.mean_Pa = 12.5;
    const nlohmann::ordered_json json = toJson(report);
    EXPECT_EQ(json["points"], 7);
    EXPECT_EQ(json["stop"], "nothing to do");
    EXPECT_EQ(json["surface"]["mean_Pa"], 12.5);
    for (const auto& [name, value] : figuresOf(report))
        if (name.rfind("surface.", 0) == 0)
            EXPECT_EQ(json["surface"][name.substr(8)].get<double>(), value) << name;
        else
            EXPECT_EQ(json[name].get<double>(), value) << name;
}

TEST(Rate, OfNothingIsNothing)
{
    SolveReport report;
    report.rms = report.max = report.level_Pa = report.loudness = report.worstShortfall = 7.0;
    report.shortPoints = 7;
    ControlPoints points;
    for (const bool absolute : {false, true})
    {
        points.absolute = absolute;
        rateLevel(points, Eigen::VectorXf(), report);
        EXPECT_EQ(report.rms + report.max + report.level_Pa + report.loudness, 0.0);
        EXPECT_EQ(report.worstShortfall, 0.0);
        EXPECT_EQ(report.shortPoints, 0);
        points.positions = Eigen::Matrix3Xd::Zero(3, 2);
        points.targets = Eigen::VectorXd::Zero(2);
        rateLevel(points, Eigen::Vector2f(3.0f, 4.0f), report);
        EXPECT_EQ(report.rms + report.max + report.level_Pa + report.loudness, 0.0);
        points = ControlPoints();
    }
}

TEST(Rate, OfSilenceIsThatEveryPointMissesAll)
{
    ControlPoints points;
    points.positions = Eigen::Matrix3Xd::Zero(3, 2);
    points.targets = Eigen::Vector2d(100.0, 50.0);
    for (const bool absolute : {false, true})
    {
        points.absolute = absolute;
        SolveReport report;
        report.rms = report.max = 4e-4;
        report.level_Pa = 100.0;
        report.loudness = 1.1;
        rateLevel(points, Eigen::Vector2f::Zero(), report);
        EXPECT_EQ(report.rms, 1.0);
        EXPECT_EQ(report.max, 1.0);
        EXPECT_EQ(report.level_Pa, 0.0);
        EXPECT_EQ(report.loudness, 0.0);
        EXPECT_EQ(report.shortPoints, absolute ? 2 : 0);
        EXPECT_EQ(report.worstShortfall, absolute ? 1.0 : 0.0);
    }
}

TEST(Rate, PointsThatNothingIsWantedOfDontCount)
{
    ControlPoints points;
    points.positions = Eigen::Matrix3Xd::Zero(3, 3);
    points.targets = Eigen::Vector3d(1.0, 0.0, 1.0);
    SolveReport report;
    rateLevel(points, Eigen::Vector3f(90.0f, 500.0f, 110.0f), report);
    EXPECT_NEAR(report.level_Pa, 100.0, 1e-9);
    EXPECT_NEAR(report.rms, 0.1, 1e-9);
    EXPECT_NEAR(report.max, 0.1, 1e-9);
}

} // namespace
} // namespace midair::haptics
