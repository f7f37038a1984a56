#pragma once

#include "samples/experiments/jnd/TrialRunner.h"

#include <osgMidair/HapticScene>
#include <osgMidair/HapticStatistics>

#include <Eigen/Core>

#include <algorithm>

#include <fmt/format.h>

namespace midair::samples
{

/// Points that reach less than this share of their pressure don't count as played.
constexpr double kLeastShare = 0.9;
/// Tolerance for equal places.
constexpr double kSamePoint_m = 1e-5;

/// Returns true if \a points are exactly the control points of \a field.
inline bool areThePointsOf(const osgMidair::HapticField& field, const Eigen::Matrix3Xd& points)
{
    if (static_cast<Eigen::Index>(field.getPoints().size()) != points.cols()) return false;
    for (const osgMidair::HapticField::ControlPoint& point : field.getPoints())
    {
        const Eigen::Vector3d at(point.position.x(), point.position.y(), point.position.z());
        if ((points.colwise() - at).colwise().norm().minCoeff() > kSamePoint_m) return false;
    }
    return true;
}

/// Returns whether \a haptics now plays \a points (m, array frame) in a field handed over since
/// \a since_s (steady clock). Without points nothing is wanted.
inline PlayedNow playedPoints(const osgMidair::HapticScene& haptics,
                              const osgMidair::HapticStatistics& now,
                              const Eigen::Matrix3Xd& points,
                              double since_s)
{
    using osgMidair::ArrayState;
    PlayedNow played;
    // A mute counts at once, also while no device is open.
    const ArrayState state = haptics.getMuted() ? ArrayState::MUTED : now.state;
    played.isReady =
        state != ArrayState::MUTED && state != ArrayState::LOST && state != ArrayState::FAULT;
    played.problem = fmt::format("the array is {}", midair::bridge::stateName(state));
    // A disabled scene has no open device, so a closed device may be about to open.
    if (!played.isReady || now.state == ArrayState::CLOSED || now.state == ArrayState::OPENING)
        return played;
    const osg::ref_ptr<const osgMidair::HapticField> field = haptics.getField();
    // A field of an earlier trial with the same points doesn't count.
    const bool areThey = field && points.cols() > 0 && field->getHandedOverTime() >= since_s &&
                         areThePointsOf(*field, points);
    if (!areThey || now.state != ArrayState::PLAYING || !field->isPlaying())
    {
        played.problem = areThey ? "the device doesn't play it" : "its field is not there yet";
        return played;
    }
    double share = 1.0;
    double wanted_Pa = 0.0;
    for (const osgMidair::HapticField::ControlPoint& point : field->getPoints())
    {
        share = std::min(share, point.wanted_Pa > 0.0 ? point.achieved_Pa / point.wanted_Pa : 0.0);
        wanted_Pa = std::max(wanted_Pa, point.wanted_Pa);
    }
    played.isPlayed = share >= kLeastShare;
    played.problem.clear();
    if (!played.isPlayed)
        played.problem = fmt::format(
            "it reaches only {:.0f} % of its {:g} Pa at a point", 100.0 * share, wanted_Pa);
    return played;
}

} // namespace midair::samples
