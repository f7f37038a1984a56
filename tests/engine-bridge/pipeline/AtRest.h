#pragma once

#include "engine-bridge/pipeline/HologramPipeline.h"
#include "tests/engine-bridge/pipeline/Fakes.h"
#include "tests/haptics/base/threads/SetClock.h"

#include <algorithm>
#include <functional>
#include <memory>
#include <vector>

/// A pipeline with the real solver, and all results of a scene at rest.
struct AtRest
{
    using Results = std::vector<std::shared_ptr<const midair::bridge::HologramResult>>;

    explicit AtRest(const std::function<void(midair::bridge::HologramOptions&)>& change = {})
    {
        midair::bridge::HologramOptions options = fakeOptions(log);
        options.solverFactory = {};
        options.clock = &clock;
        if (change) change(options);
        pipeline = std::make_unique<midair::bridge::HologramPipeline>(std::move(options));
    }

    /// Attends for \a time_s. Returns the results with another field than before.
    Results rest(double time_s)
    {
        Results results;
        const double until_s = clock.now_s() + time_s;
        while (clock.now_s() < until_s)
        {
            const std::shared_ptr<const midair::bridge::HologramResult> before = newest;
            if (auto next = pipeline->attend()) newest = std::move(next);
            if (newest && (!before || newest->played() != before->played()))
                results.push_back(newest);
            clock.pass(std::clamp(pipeline->rest_s(), 1e-4, 0.05));
        }
        return results;
    }

    /// Shows \a snapshot. Returns its result.
    std::shared_ptr<const midair::bridge::HologramResult>
    show(const midair::bridge::SceneSnapshot& snapshot)
    {
        return newest = pipeline->process(snapshot);
    }

    midair::test::SetClock clock;
    std::shared_ptr<FakeLog> log = std::make_shared<FakeLog>();
    std::unique_ptr<midair::bridge::HologramPipeline> pipeline;
    std::shared_ptr<const midair::bridge::HologramResult> newest;
};
