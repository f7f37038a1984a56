#pragma once

#include "engine-bridge/pipeline/HologramPipeline.h"
#include "tests/engine-bridge/pipeline/Fakes.h"
#include "tests/haptics/base/threads/SetClock.h"

#include <algorithm>
#include <functional>
#include <memory>
#include <vector>

/// 49 points, 8 mm apart; a surface would be evened out.
inline midair::bridge::SceneSnapshot pointsSnapshot(double x_m = 0.0)
{
    auto mesh = std::make_shared<midair::haptics::TriangleMesh>();
    mesh->vertices.resize(3, 49);
    for (int row = 0; row < 7; ++row)
        for (int column = 0; column < 7; ++column)
            mesh->vertices.col(7 * row + column) << 8e-3 * (column - 3), 0.0, 8e-3 * (row - 3);
    mesh->triangles.resize(3, 49);
    for (int i = 0; i < 49; ++i)
        mesh->triangles.col(i).setConstant(i);
    midair::bridge::SceneSnapshot snapshot = squareSnapshot(x_m);
    snapshot.objects.front().mesh = mesh;
    snapshot.objects.front().properties.sampling = midair::haptics::Sampling::POINTS;
    snapshot.objects.front().properties.spacing_m = 8e-3;
    return snapshot;
}

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
