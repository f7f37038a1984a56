// Numbers that a scene would have the machine busy or full with.
#include "plugin/engine/SceneAccess.h"
#include "tests/hostile/Hostile.h"

#include <osg/Group>

#include <chrono>
#include <limits>

#include <sys/resource.h>

using namespace osgMidair;

namespace
{

class HostileNumbers : public Hostile
{
protected:
    /// Seconds that it takes to let go of \a scene in the middle of its work.
    static double secondsToClose(osg::ref_ptr<HapticScene> scene)
    {
        auto viewer = std::make_unique<HeadlessViewer>(scene);
        viewer->framesFor(0.3);
        const auto start = std::chrono::steady_clock::now();
        viewer.reset();
        scene = nullptr;
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    }
};

long mostMemory_MB()
{
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return usage.ru_maxrss / 1024;
}

/// Seconds, not tenths of them: machines are shared. What is asked for here took 20 to 60 s.
constexpr double kClosing_s = 15.0;

} // namespace

TEST_P(HostileNumbers, NoSolverHoldsTheProgramUp)
{
    for (const char* solver : {"sdp-bcd", "gauss-newton", "gs", "gs-pat", "wgs", "greedy", "lbfgs"})
    {
        const auto scene = fromFile(
            [&](HapticScene& s)
            {
                s.setArray("octagon");
                s.setSolver(solver);
                s.setMaxIterations(1000000);
                s.setRmsTolerance(0.0);
            });
        EXPECT_LT(secondsToClose(scene), kClosing_s) << solver;
    }
}

TEST_P(HostileNumbers, NeitherThreadsNorFieldsInTurnDo)
{
    const auto scene = fromFile(
        [](HapticScene& s)
        {
            s.setArray("octagon");
            s.setThreads(256);
            s.setSubsets(64);
            s.setCycle(64);
            s.setCycleSteps(16);
            s.setMonitorInterval(1e-9);
        });
    EXPECT_LT(secondsToClose(scene), kClosing_s);
}

TEST_P(HostileNumbers, MemoryStaysBounded)
{
    const long before_MB = mostMemory_MB();
    const auto scene = fromFile(
        [](HapticScene& s)
        {
            s.setArray("octagon");
            s.setMaxPoints(1000000);
            auto* surface = dynamic_cast<HapticSurface*>(s.getChild(0)->asGroup()->getChild(0));
            ASSERT_NE(surface, nullptr);
            surface->setSpacing(0.001);
        });
    EXPECT_LT(secondsToClose(scene), kClosing_s);
    EXPECT_LT(mostMemory_MB() - before_MB, 1500);
}

TEST_P(HostileNumbers, NoNumberIsTooStrange)
{
    const double nan = std::numeric_limits<double>::quiet_NaN();
    for (const double number : {nan, 1e308, -1e308, 1e-308, 0.0})
    {
        const auto scene = fromFile(
            [&](HapticScene& s)
            {
                s.setMetresPerUnit(number);
                s.setTemperature(number);
                s.setLambda(number);
                s.setLoudness(number);
                s.setReach(number);
                s.setFieldRate(number);
                s.setMonitorInterval(number);
                s.setMotionTolerance(number);
                s.setDeadline(number);
                s.setCalibration(osg::Matrixd::translate(number, number, number));
            });
        viewBriefly(*scene);
        if (const auto result = SceneAccess::latestResult(*scene))
        {
            EXPECT_TRUE(result->played().allFinite()) << number;
            EXPECT_TRUE(result->achieved_Pa.allFinite()) << number;
        }
    }
}

INSTANTIATE_TEST_SUITE_P(Formats, HostileNumbers, testing::Values("osgt", "osgb", "osgx"));
