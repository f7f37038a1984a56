#include "tests/Halt.h"
#include "tests/plugin/KitTest.h"

#include <osgMidair/FieldSolver>
#include <osgMidair/HapticField>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <stdexcept>

#include <gtest/gtest.h>

using namespace osgMidair;

namespace
{

/// Adds up the foci of all points, at a fifth of full drive; or does something wrong.
class Foci : public FieldSolver
{
public:
    enum Mistake
    {
        NONE,
        NOT_FINITE,
        TOO_LARGE,
        THROWS,
        GIVES_UP
    };
    explicit Foci(Mistake mistake) : _mistake(mistake) {}

    bool solve(const Problem& problem, std::complex<float>* q, std::string& error) override
    {
        for (unsigned int i = 0; i < problem.transducers; ++i)
        {
            std::complex<float> sum;
            for (unsigned int l = 0; l < problem.points; ++l)
                sum += std::conj(problem.matrix[l * problem.transducers + i]);
            q[i] = std::polar(0.2F, std::arg(sum));
        }
        if (_mistake == THROWS) throw std::runtime_error("out of ideas");
        if (_mistake == GIVES_UP) error = "too many points";
        if (_mistake == NOT_FINITE) q[7] = std::numeric_limits<float>::quiet_NaN();
        if (_mistake == TOO_LARGE) q[8] = {0.0F, -2.5F};
        return _mistake != GIVES_UP;
    }

private:
    const Mistake _mistake;
};

/// Takes as long as \a isLong is set.
class SlowFoci : public Foci
{
public:
    explicit SlowFoci(const Halt& isLong) : Foci(NONE), _isLong(isLong) {}

    bool solve(const Problem& problem, std::complex<float>* q, std::string& error) override
    {
        _isLong.pass();
        return Foci::solve(problem, q, error);
    }

private:
    const Halt& _isLong;
};

FieldSolverFactory maker(Foci::Mistake mistake)
{
    return [mistake] { return osg::ref_ptr<FieldSolver>(new Foci(mistake)); };
}

} // namespace

TEST(FieldSolver, ANameHasOneMeaning)
{
    std::string error;
    ASSERT_TRUE(registerSolver("foci-1", maker(Foci::NONE), error)) << error;
    EXPECT_FALSE(registerSolver("foci-1", maker(Foci::NONE), error));
    EXPECT_EQ(error, "the name \"foci-1\" is taken");
    EXPECT_FALSE(registerSolver("gs", maker(Foci::NONE), error));
    EXPECT_EQ(error, "the name \"gs\" is taken");
    EXPECT_FALSE(registerSolver("My solver", maker(Foci::NONE), error));
    EXPECT_EQ(error,
              "\"My solver\" is not a valid name of a solver; it must have 1 to 32 small letters, "
              "digits and "
              "dashes");
    EXPECT_FALSE(registerSolver("nothing", {}, error));
    EXPECT_EQ(error, "the solver \"nothing\" was registered without a factory");
}

TEST(FieldSolver, SolvesAScene)
{
    std::string error;
    ASSERT_TRUE(registerSolver("foci-2", maker(Foci::NONE), error)) << error;
    BoxScene box;
    box.scene->setSolver("foci-2");
    HeadlessViewer viewer(box.scene);
    ASSERT_TRUE(viewer.framesUntil([&] { return box.points() > 0; }));
    const auto field = box.scene->getField();
    EXPECT_TRUE(field->isPlaying());
    for (const std::complex<float>& q : field->getActivations())
        EXPECT_NEAR(std::abs(q), 0.2, 0.004) << "as it was asked for, on a level of the device";
    double sum_Pa = 0.0;
    for (const HapticField::ControlPoint& point : field->getPoints())
        sum_Pa += point.achieved_Pa;
    const HapticStatistics statistics = box.scene->getStatistics();
    EXPECT_GT(sum_Pa, 0.0);
    EXPECT_NEAR(statistics.level_Pa,
                sum_Pa / static_cast<double>(field->getPoints().size()),
                1e-3 * statistics.level_Pa);
    EXPECT_GT(statistics.rms, 0.0);
    EXPECT_GT(statistics.loudness, 0.0);
}

// The thread that solves can't say so meanwhile.
TEST(FieldSolver, OneThatTakesLongIsToldOnceWhileItDoes)
{
    Halt isLong;
    std::string error;
    ASSERT_TRUE(registerSolver(
        "foci-slow", [&] { return osg::ref_ptr<FieldSolver>(new SlowFoci(isLong)); }, error))
        << error;
    BoxScene box;
    box.scene->setSolver("foci-slow");
    HeadlessViewer viewer(box.scene);
    ASSERT_TRUE(viewer.framesUntil([&] { return box.points() > 0; }));
    const std::uint64_t heard = box.scene->getField()->getFrameNumber();
    isLong = true;
    int moves = 0;
    const auto told = [&]
    {
        box.move(1e-4 * ++moves);
        const auto all = box.scene->getStatistics().told;
        const auto slow =
            std::find_if(all.begin(),
                         all.end(),
                         [](const HapticMessage& one) { return one.code == "solver.slow"; });
        return slow == all.end() ? HapticMessage() : *slow;
    };
    ASSERT_TRUE(viewer.framesUntil([&] { return !told().code.empty(); }));
    EXPECT_EQ(told().severity, HapticMessage::WARNING);
    const std::string text = told().text;
    const std::string begin = "the solver has been working on one field for ";
    ASSERT_EQ(text.rfind(begin, 0), 0u) << text;
    EXPECT_GE(std::stod(text.substr(begin.size())), 1.0) << text;
    EXPECT_NE(text.find(" s; still playing the field of frame "), std::string::npos) << text;
    EXPECT_GE(std::stoull(text.substr(text.rfind(' ') + 1)), heard);
    for (int i = 0; i < 30; ++i)
    {
        told();
        viewer.frame();
    }
    EXPECT_EQ(told().count, 1u) << "once while it lasts";
    isLong = false;
    ASSERT_TRUE(viewer.framesUntil(
        [&]
        {
            told();
            return box.scene->getField()->getFrameNumber() > heard + 30;
        }));
    EXPECT_EQ(told().count, 1u);
}

TEST(FieldSolver, WhatIsWrongIsRefusedByName)
{
    struct Case
    {
        const char* name;
        Foci::Mistake mistake;
        const char* message;
    };
    const Case cases[] = {
        {"foci-nan",
         Foci::NOT_FINITE,
         "solver \"foci-nan\" has failed: its activation 7 is nan+0i; it must be finite and of an "
         "amplitude "
         "of "
         "at most 1"},
        {"foci-loud",
         Foci::TOO_LARGE,
         "solver \"foci-loud\" has failed: its activation 8 is 0-2.5i; it must be finite and of an "
         "amplitude "
         "of "
         "at most 1"},
        {"foci-throws",
         Foci::THROWS,
         "solver \"foci-throws\" has failed: it has thrown \"out of ideas\""},
        {"foci-gives-up", Foci::GIVES_UP, "solver \"foci-gives-up\" has failed: too many points"}};
    for (const Case& one : cases)
    {
        std::string error;
        ASSERT_TRUE(registerSolver(one.name, maker(one.mistake), error)) << error;
        BoxScene box;
        box.scene->setSolver(one.name);
        HeadlessViewer viewer(box.scene);
        EXPECT_TRUE(viewer.framesUntil([&] { return says(*box.scene, one.message); })) << one.name;
        EXPECT_FALSE(box.scene->getField()->isPlaying());
        const auto told = box.scene->getStatistics().told;
        EXPECT_TRUE(std::any_of(told.begin(),
                                told.end(),
                                [](const HapticMessage& each)
                                { return each.code == "field.failed"; }))
            << one.name;
    }
}

TEST(FieldSolver, AnUnknownNameIsToldWithThoseThatAreKnown)
{
    std::string error;
    ASSERT_TRUE(registerSolver("foci-3", maker(Foci::NONE), error)) << error;
    BoxScene box;
    box.scene->setSolver("fici");
    HeadlessViewer viewer(box.scene);
    ASSERT_TRUE(viewer.framesUntil(
        [&] { return says(*box.scene, "unknown solver 'fici'; known are gauss-newton, "); }));
    EXPECT_TRUE(says(*box.scene, "foci-3"));
}
