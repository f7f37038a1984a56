#pragma once

#include <Eigen/Core>

#include <cstdint>
#include <deque>
#include <vector>

namespace midair::bridge
{

/// A place where a focus was.
struct TrailPoint
{
    double time_s = 0.0;                             ///< steady clock
    Eigen::Vector3d place = Eigen::Vector3d::Zero(); ///< m, array frame
    double intensity = 0.0;                          ///< 0 .. 1, with fades
};

using SensationTrail = std::deque<TrailPoint>;

/// A sensation as played, for overlays and programs.
struct SensationView
{
    std::uint64_t object = 0;                        ///< HapticObject::touchId()
    int index = -1;                                  ///< of its object in the snapshot; -1: unknown
    bool isPlaying = false;                          ///< from its begin until it has faded out
    bool isStopped = false;                          ///< the pattern has come to its stop
    double patternTime_ms = 0.0;                     ///< see haptics::SensationSample
    double intensity = 0.0;                          ///< 0 .. 1, with fades
    double pressure_Pa = 0.0;                        ///< wanted peak
    Eigen::Vector3d place = Eigen::Vector3d::Zero(); ///< m, array frame
    /// the places of the last turn, of kTrail_s to a second, at most 512
    std::vector<TrailPoint> trail;

    static constexpr double kTrail_s = 0.05;
};

} // namespace midair::bridge
