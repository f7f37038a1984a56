#pragma once

#include "engine-bridge/pipeline/PointAssembler.h"
#include "engine-bridge/solving/OneSolve.h"
#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/base/text/MessageLog.h"
#include "haptics/base/threads/StopToken.h"

#include <osgMidair/SceneSettings>

#include <Eigen/Core>

#include <memory>

namespace midair::bridge
{

/// A scene that is solved once, like midair-solve, and not played.
struct SceneSolve
{
    std::shared_ptr<const haptics::TransducerArray>
        array;                 ///< its levels have passed keepToSignal()
    SceneSettings settings;    ///< with all caps; maxPoints 0: up to 2000
    SceneSnapshot snapshot;    ///< with its hands and ears
    SilenceRemedy remedy = {}; ///< names of the settings in messages
    base::StopToken stop = {};
};

/// Result of solveScene().
struct SolvedScene
{
    SolvedFields fields;
    /// shadows and all reflectors included
    std::shared_ptr<const haptics::TransducerArray> array;
    haptics::Medium medium;
    Eigen::Matrix3Xd ears; ///< 3 x n, listening places besides those around, array frame
};

/// Solves on this thread and on the settings' threads. Throws base::InputError for a scene that
/// can't be solved, and base::Stopped.
SolvedScene solveScene(const SceneSolve& scene, base::MessageLog& messages);

/// True if the field is silent, for a reason given in the report or the messages.
bool isSilent(haptics::StopReason stop);

/// Listening places of a field on \a array: those around it, and \a ears (3 x n).
Eigen::Matrix3Xd placesHeard(const haptics::TransducerArray& array, const Eigen::Matrix3Xd& ears);

} // namespace midair::bridge
