#include "plugin/engine/HapticEngine.h"
#include "plugin/engine/SceneAccess.h"
#include "tests/Halt.h"
#include "tests/plugin/KitTest.h"

#include <osg/Switch>

#include <atomic>

#include <gtest/gtest.h>

using namespace osgMidair;

namespace
{

/// Doesn't return from solve() while held.
class HeldSolver : public midair::haptics::HologramSolver
{
public:
    HeldSolver(const Halt& held, std::atomic<int>& begun) : _held(held), _begun(begun) {}

    midair::haptics::SolveReport solve(const midair::haptics::ControlPoints& points,
                                       const midair::haptics::TransducerArray& array,
                                       const midair::haptics::Medium&,
                                       Eigen::VectorXcf& q) override
    {
        ++_begun;
        _held.pass();
        q.setOnes(array.size());
        midair::haptics::SolveReport report;
        report.points = points.size();
        return report;
    }
    const midair::haptics::SolverOptions& options() const override { return _options; }

private:
    const Halt& _held;
    std::atomic<int>& _begun;
    midair::haptics::SolverOptions _options;
};

} // namespace

TEST(Threading, NoFrameWaitsForASolverThatSleeps)
{
    Halt held(true);
    std::atomic<int> begun{0};
    BoxScene box;
    SceneAccess::engine(*box.scene)
        .setOptionsFilter(
            [&](midair::bridge::HologramOptions& options)
            {
                options.solverFactory =
                    [&](const std::string&, const midair::haptics::SolverOptions&)
                { return std::make_unique<HeldSolver>(held, begun); };
            });
    HeadlessViewer viewer(box.scene);
    ASSERT_TRUE(viewer.framesUntil([&] { return begun == 1; }));
    // Were any of these to wait, none would ever return: the solver is let go only after them.
    for (int i = 0; i < 200; ++i)
    {
        box.move(1e-3 * i);
        viewer.frame();
        box.scene->getStatistics();
    }
    box.scene->setLoudness(0.5); // another pipeline is wanted
    viewer.frames(5);
    EXPECT_EQ(begun, 1);
    const unsigned int frame = viewer.viewer.getFrameStamp()->getFrameNumber();
    held = false;
    ASSERT_TRUE(
        viewer.framesUntil([&] { return box.result() && box.result()->frame + 5 >= frame; }));
    EXPECT_LE(begun, 4) << "the newest won; the others were dropped";
}

TEST(Threading, ResultsMayBeReadFromAnyThreadWhileTheSceneMoves)
{
    BoxScene box;
    HeadlessViewer viewer(box.scene);
    std::atomic<bool> stop{false};
    std::atomic<int> reads{0};
    std::atomic<int> looks{0};
    std::thread reader(
        [&]
        {
            while (!stop)
            {
                const auto result = SceneAccess::latestResult(*box.scene);
                if (result && result->achieved_Pa.size() == result->points.size()) ++reads;
                box.scene->getStatistics();
                SceneAccess::engine(*box.scene).array();
                ++looks;
            }
        });
    for (int i = 0; i < 60; ++i)
    {
        const int before = looks;
        box.move(0.02 * std::sin(0.1 * i));
        if (i % 20 == 10) box.scene->setTemperature(20.0 + 0.1 * i); // a new pipeline
        viewer.frame();
        EXPECT_TRUE(eventually([&] { return looks > before; }));
    }
    EXPECT_TRUE(viewer.framesUntil([&] { return reads > 0; }));
    stop = true;
    reader.join();
}

TEST(Threading, ScenesComeAndGoWhileSolving)
{
    for (int i = 0; i < 10; ++i)
    {
        BoxScene box;
        HeadlessViewer viewer(box.scene);
        for (int k = 0; k <= i; ++k)
        {
            box.move(1e-3 * k);
            viewer.frame();
        }
    }
}
