#pragma once

#include "engine-bridge/pipeline/FieldMaker.h"
#include "engine-bridge/pipeline/SceneSnapshot.h"

#include <Eigen/Core>

#include <cstdint>
#include <vector>

namespace midair::bridge
{

/// The scene as it was last solved, and what has been made for it while it rests.
struct StillScene
{
    struct Set
    {
        MadeFields made; ///< no fields: not yet
        Eigen::VectorXf achieved_Pa;
    };

    SceneSnapshot snapshot;
    std::vector<Set> sets;
    int next = 0;         ///< set for the next update
    bool current = false; ///< snapshot and sets are of what is played
    bool setsMissing = false;
    bool outlineMissing = false;
    bool submitted = false;   ///< what is played was given to the monitor
    std::uint64_t number = 0; ///< of the last field that was
    std::uint64_t shown = 0;  ///< of the last one whose result was handed on
};

} // namespace midair::bridge
