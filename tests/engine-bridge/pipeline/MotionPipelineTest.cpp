#include "engine-bridge/hands/tracking/NamedSource.h"
#include "engine-bridge/pipeline/HologramPipeline.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/base/Percentile.h"
#include "tests/engine-bridge/pipeline/Fakes.h"
#include "tests/haptics/base/threads/SetClock.h"
#include "tests/haptics/surface/SphereMesh.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <functional>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

namespace midair::bridge
{

namespace
{

using Eigen::Isometry3d;
using Eigen::Vector3d;
using PathAt = std::function<Vector3d(double)>;

constexpr double kFrame_s = 1.0 / 60.0;
constexpr double kLight_s = 0.022;

/// A solver that takes its time, on a clock that is set.
class LateSolver final : public haptics::HologramSolver
{
public:
    LateSolver(std::unique_ptr<haptics::HologramSolver> solver,
               midair::test::SetClock& clock,
               double s) :
        _solver(std::move(solver)),
        _clock(clock),
        _takes_s(s)
    {
    }
    haptics::SolveReport solve(const haptics::ControlPoints& points,
                               const haptics::TransducerArray& array,
                               const haptics::Medium& medium,
                               Eigen::VectorXcf& q) override
    {
        _clock.jump(_takes_s);
        return _solver->solve(points, array, medium, q);
    }
    const haptics::SolverOptions& options() const override { return _solver->options(); }

private:
    std::unique_ptr<haptics::HologramSolver> _solver;
    midair::test::SetClock& _clock;
    double _takes_s;
};

/// A ball of 2 mm over one board, in frames of 60 Hz that a pipeline of 38 ms takes up whenever it
/// is free.
struct MovingBall
{
    explicit MovingBall(PathAt itsPath) : path(std::move(itsPath))
    {
        HologramOptions options;
        options.array = haptics::TransducerArray::load("board");
        options.clock = &clock;
        options.solverFactory = [this](const std::string& name, const haptics::SolverOptions& of)
        { return std::make_unique<LateSolver>(haptics::makeSolver(name, of), clock, 0.038); };
        options.deviceFactory = [this](const std::string&, const device::DeviceLayout& layout)
        {
            auto made = std::make_unique<FakeDevice>(log, layout.transducers);
            device = made.get();
            return made;
        };
        array = options.array;
        wavelength_m = options.wavelength_m();
        pipeline = std::make_unique<HologramPipeline>(std::move(options));
    }

    SceneSnapshot frame(int k) const
    {
        SceneSnapshot snapshot;
        snapshot.frame = static_cast<std::uint64_t>(k);
        snapshot.time_s = start_s + k * kFrame_s;
        snapshot.simulationTime_s = k * kFrame_s;
        snapshot.lightAfter_s = kLight_s;
        snapshot.carriesOn = isCarried;
        snapshot.handsLate_s = handsLate_s;
        HapticObject& ball = snapshot.objects.emplace_back();
        ball.id = ball.meshId = 1;
        ball.path = "Ball";
        ball.mesh = mesh;
        ball.properties.render = render;
        ball.pose.translation() = path(k * kFrame_s);
        return snapshot;
    }

    /// Processes the newest frame; a pipeline that is idle waits for the next one. Returns its
    /// number.
    int step()
    {
        const int newest = static_cast<int>(std::floor((clock.now_s() - start_s) / kFrame_s));
        frameNow = std::max(newest, frameNow + 1);
        clock.jump(std::max(0.0, start_s + frameNow * kFrame_s - clock.now_s()));
        result = pipeline->process(frame(frameNow));
        return frameNow;
    }

    /// Where what is played sounds loudest: apart from all of the kit's code but the activations.
    Vector3d focus(Vector3d near) const
    {
        const std::vector<std::complex<float>> q = device->played();
        const double k = 2.0 * M_PI / wavelength_m;
        const auto loudness = [&](const Vector3d& place)
        {
            std::complex<double> sum = 0.0;
            for (Eigen::Index i = 0; i < array.size(); ++i)
            {
                const double r = (place - array.positions.col(i)).norm();
                sum += std::complex<double>(q[static_cast<std::size_t>(i)]) *
                       std::polar(1.0 / r, -k * r);
            }
            return std::abs(sum);
        };
        for (double step_m = 4e-3; step_m > 2e-5;)
        {
            Vector3d best = near;
            for (int axis = 0; axis < 2; ++axis) // across the array; along it a focus is long
                for (const double way : {-step_m, step_m})
                {
                    Vector3d tried = near;
                    tried[axis] += way;
                    if (loudness(tried) > loudness(best)) best = tried;
                }
            if (best == near) step_m *= 0.5;
            near = best;
        }
        return near;
    }

    /// How far what is heard is from what is seen, across the array, when the sound of the last
    /// step arrives.
    double apart_m() const
    {
        const double heard_s = result->handedOver_s + TrackedDelay::kSound_s;
        const Vector3d seen = path(heard_s - kLight_s - start_s);
        return (focus(path(frameNow * kFrame_s)) - seen).head<2>().norm();
    }

    PathAt path;
    bool isCarried = true;
    Render render = Render::OBJECT;
    double handsLate_s = 0.0;
    midair::test::SetClock clock;
    double start_s = clock.now_s();
    std::shared_ptr<FakeLog> log = std::make_shared<FakeLog>();
    std::shared_ptr<const haptics::TriangleMesh> mesh = sphere(0.002, 6);
    FakeDevice* device = nullptr;
    haptics::TransducerArray array;
    double wavelength_m = 0.0;
    std::unique_ptr<HologramPipeline> pipeline;
    std::shared_ptr<const HologramResult> result;
    int frameNow = -1;
};

PathAt line(double speed)
{
    return [speed](double t) { return Vector3d(-0.06 + speed * t, 0.0, 0.2); };
}

double worstApart_m(MovingBall& ball, int steps, int first)
{
    double worst_m = 0.0;
    for (int i = 0; i < steps; ++i)
    {
        ball.step();
        if (i >= first) worst_m = std::max(worst_m, ball.apart_m());
    }
    return worst_m;
}

} // namespace

// 2 mm are asked for. The wait for the pipeline, 0 to 17 ms, is in it.
TEST(MotionPipeline, ABallIsPlayedWhereItIsSeenWhenItsSoundArrives)
{
    MovingBall ball(line(0.3));
    EXPECT_LT(worstApart_m(ball, 9, 4), 5e-4);
}

// What it was: 5 to 10 mm, by 17 to 34 ms from the light to the sound.
TEST(MotionPipeline, SwitchedOffTheBallIsLate)
{
    MovingBall ball(line(0.3));
    ball.isCarried = false;
    const double worst_m = worstApart_m(ball, 9, 4);
    EXPECT_GT(worst_m, 5e-3);
    EXPECT_LT(worst_m, 0.012);
}

TEST(MotionPipeline, ABallOnACircleIsPlayedWhereItIsSeen)
{
    MovingBall ball([](double t)
                    { return Vector3d(0.04 * std::cos(7.5 * t), 0.04 * std::sin(7.5 * t), 0.2); });
    EXPECT_LT(worstApart_m(ball, 20, 6), 2e-3);
}

TEST(MotionPipeline, AtRestTheFieldIsTheSameToTheLastBit)
{
    std::vector<Eigen::VectorXcf> fields;
    for (const bool isCarried : {false, true})
    {
        MovingBall ball(line(0.0));
        ball.isCarried = isCarried;
        for (int i = 0; i < 6; ++i)
            ball.step();
        EXPECT_EQ(ball.pipeline->counters().solves, 1U);
        EXPECT_EQ(ball.pipeline->counters().skippedUnmoved, 5U);
        fields.push_back(ball.result->played());
    }
    EXPECT_EQ(fields[0], fields[1]);
}

TEST(MotionPipeline, WhatComesToRestIsPlayedWhereItRests)
{
    MovingBall ball([](double t) { return line(0.3)(std::min(t, 0.35)); });
    for (int i = 0; i < 12; ++i)
        ball.step();
    EXPECT_EQ(ball.result->points.positions.rowwise().mean().x(),
              [&]
              {
                  MovingBall still([](double) { return line(0.3)(0.35); });
                  still.step();
                  return still.result->points.positions.rowwise().mean().x();
              }());
}

TEST(MotionPipeline, WhatIsFeltByContactsGoesWithTheHands)
{
    for (const double late_s : {0.0, 0.05})
    {
        MovingBall ball(line(0.3));
        ball.render = Render::AUTO;
        ball.handsLate_s = late_s;
        for (int i = 0; i < 8; ++i)
            ball.step();
        const double ahead_m =
            ball.result->points.positions.row(0).mean() - ball.path(ball.frameNow * kFrame_s).x();
        EXPECT_NEAR(ahead_m, late_s > 0.0 ? 0.0 : 0.3 * 0.025, 3.5e-3);
    }
}

// Within 10 % or 0.3 mm of what is found apart from it.
TEST(MotionPipeline, WhatIsLeftOfAMotionIsMeasured)
{
    for (const bool isCarried : {false, true})
    {
        MovingBall ball(line(0.3));
        ball.isCarried = isCarried;
        std::vector<double> apart_m;
        for (int i = 0; i < 11; ++i)
        {
            ball.step();
            if (i >= 4) apart_m.push_back(ball.apart_m());
        }
        const std::vector<SeenObject> seen = ball.pipeline->seen();
        ASSERT_EQ(seen.size(), 1U);
        EXPECT_EQ(seen[0].path, "Ball");
        EXPECT_FALSE(seen[0].isTouched);
        ASSERT_TRUE(seen[0].motion.isKnown);
        const double median_m = base::percentile(apart_m, 0.5);
        EXPECT_NEAR(seen[0].motion.median_m, median_m, std::max(3e-4, 0.1 * median_m));
    }
}

TEST(MotionPipeline, AnObjectAtRestHasNoMotionAndANewOneIsAtRest)
{
    MovingBall ball([](double t) { return line(0.3)(std::min(t, 0.35)); });
    ball.step();
    EXPECT_TRUE(ball.pipeline->seen()[0].motion.isKnown);
    EXPECT_EQ(ball.pipeline->seen()[0].motion.most_m, 0.0);
    ball.step();
    EXPECT_FALSE(ball.pipeline->seen()[0].motion.isKnown) << "nothing is measured yet";
    for (int i = 0; i < 60; ++i)
        ball.step();
    EXPECT_TRUE(ball.pipeline->seen()[0].motion.isKnown);
    EXPECT_EQ(ball.pipeline->seen()[0].motion.most_m, 0.0);
}

} // namespace midair::bridge
