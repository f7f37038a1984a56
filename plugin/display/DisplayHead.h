#pragma once

#include "engine-bridge/heads/HeadTracker.h"

#include <osgMidair/HapticScene>
#include <osgMidair/HeadSource>

#include <Eigen/Geometry>

#include <string>
#include <vector>

namespace osgMidair
{

/// The position of a display's head, in metres in the world: from the display's own source, from
/// the scene ("scene"), or from the program. A moving head also becomes the scenes' head, so that
/// the ears are where the eyes are.
class DisplayHead
{
public:
    /// Opens \a eye. Throws on errors in it. \a before: the position until a head is known.
    DisplayHead(const std::string& eye, const Eigen::Isometry3d& before);

    /// Uses the program's own head from now on.
    void set(const Eigen::Isometry3d& pose, bool isTracked, double time_s);
    /// Finds the head for light shown soon after \a time_s. \a scene: the scene of the head
    /// "scene"; null: none.
    void locate(double time_s, const HapticScene* scene);
    /// Gives \a scene this head, if it moves and the scene has none of its own.
    void giveTo(HapticScene& scene) const;

    const Eigen::Isometry3d& pose() const { return _pose; } ///< the last known one
    bool isKnown() const { return _isKnown; }               ///< there was one
    bool isLost() const { return _isLost; }                 ///< for more than 0.2 s
    std::string status() const;
    /// Returns the source's messages, each once.
    std::vector<std::string> takeMessages();

private:
    void take(const Eigen::Isometry3d& pose, double time_s);

    enum class From
    {
        SOURCE,
        SCENE,
        PROGRAM
    };

    From _from = From::SOURCE;
    const bool _isFixed;
    midair::bridge::HeadTracker _tracker;
    const osg::ref_ptr<InjectedHead> _given = new InjectedHead; ///< for scenes
    Eigen::Isometry3d _pose;
    bool _isKnown = false;
    bool _isTracked = false; ///< now
    bool _isLost = false;
    double _seen_s = -1.0; ///< below 0: locate() was never called
};

} // namespace osgMidair
