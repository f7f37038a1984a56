#pragma once

#include "engine-bridge/hands/HandProximity.h"
#include "haptics/base/text/MessageLog.h"

#include <osgMidair/TouchCallback>

#include <osg/Node>
#include <osg/ref_ptr>

#include <Eigen/Geometry>

#include <cstdint>
#include <functional>
#include <vector>

namespace osgMidair
{

/// Tells the touches that hands begin and end, at nodes and in the scene's units. For the update
/// thread.
class TouchTeller
{
public:
    void setCallback(TouchCallback* callback) { _callback = callback; }
    TouchCallback* callback() const { return _callback; }

    /// A touch that begins, goes on or ends.
    struct Told
    {
        midair::bridge::TouchEvent::Kind kind = midair::bridge::TouchEvent::ENTER;
        std::uint64_t object = 0;
        osg::ref_ptr<osg::Node> node; ///< keeps that of the touch
        Touch touch;
    };

    /// Returns what is to be told of \a touched, and keeps current(). \a nodeOf returns the node of
    /// an object or null. \a arrayToScene: transform from the array to the world in scene units.
    std::vector<Told> gather(const midair::bridge::HandProximity& touched,
                             const std::function<osg::Node*(std::uint64_t)>& nodeOf,
                             const Eigen::Affine3d& arrayToScene);

    /// The touches that have begun and not ended, by the last gather().
    std::vector<Touch> current() const;

    /// Calls the callbacks. These may do anything with the scene, so call it last. Returns what
    /// they have thrown.
    std::vector<midair::base::Message> tell(const std::vector<Told>& all);

private:
    osg::ref_ptr<TouchCallback> _callback; ///< for all nodes
    std::vector<Told> _current;            ///< begun and not ended
};

} // namespace osgMidair
