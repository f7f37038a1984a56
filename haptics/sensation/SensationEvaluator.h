#pragma once

#include "haptics/sensation/SensationSample.h"
#include "haptics/sensation/SensationTrack.h"
#include "haptics/sensation/SensationValues.h"

#include <Eigen/Core>

#include <cstdint>
#include <memory>

namespace midair::haptics
{

/// What an evaluation leaves to the next one. All 0 at the start of a pattern.
struct SensationState
{
    double last_ms = 0.0;    ///< time in the pattern of the last evaluation
    double offset_ms = 0.0;  ///< time in the pattern minus time
    std::uint64_t draws = 0; ///< random numbers so far
};

/// Evaluates a pattern exactly as AdapTics does (adaptics-pattern-evaluator 0.7.0-alpha.1), to
/// compare with it: one jump an evaluation, so loops take longer at low rates; brush and modulation
/// follow the time, not the time in the pattern; intensities aren't limited, NaN and infinity are
/// passed on. Scenes play patterns with SensationPlayer.
class SensationEvaluator
{
public:
    /// \a seed: of random intensities.
    explicit SensationEvaluator(std::shared_ptr<const Sensation> sensation,
                                std::uint64_t seed = 1) :
        _track(std::move(sensation)),
        _seed(seed)
    {
    }

    const Sensation& sensation() const { return _track.sensation(); }

    /// Returns the sample at \a time_ms since the start, and changes \a state. \a frame: applied to
    /// the path with division by w, but not to the brush. Doesn't allocate.
    SensationSample evaluate(double time_ms,
                             const SensationValues& values,
                             SensationState& state,
                             const Eigen::Matrix4d& frame = Eigen::Matrix4d::Identity()) const;

private:
    SensationTrack _track;
    std::uint64_t _seed;
};

} // namespace midair::haptics
