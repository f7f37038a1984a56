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

/// Reports the beginning and end of touches, at nodes and in scene units. For the update thread.
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
        osg::ref_ptr<osg::Node> node; ///< keeps the touch's node alive
        Touch touch;
    };

    /// Returns the changes in \a touched to report, and updates current(). \a nodeOf returns the
    /// node of an object or null. \a arrayToScene: transform from the array to the world in scene
    /// units.
    std::vector<Told> gather(const midair::bridge::HandProximity& touched,
                             const std::function<osg::Node*(std::uint64_t)>& nodeOf,
                             const Eigen::Affine3d& arrayToScene);

    /// The touches that have not ended, as of the last gather().
    std::vector<Touch> current() const;

    /// Calls the callbacks. They may change the scene, so call it last. Returns their exceptions as
    /// messages.
    std::vector<midair::base::Message> tell(const std::vector<Told>& all);

private:
    osg::ref_ptr<TouchCallback> _callback; ///< for all nodes
    std::vector<Told> _current;            ///< begun and not ended
};

} // namespace osgMidair
