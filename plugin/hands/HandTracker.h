#pragma once

#include "engine-bridge/hands/HandProximity.h"
#include "engine-bridge/pipeline/HologramResult.h"
#include "engine-bridge/pipeline/SceneSnapshot.h"

#include <osgMidair/HandSource>
#include <osgMidair/TouchCallback>

#include <Eigen/Geometry>

#include <functional>
#include <string>
#include <vector>

namespace osgMidair
{

/// Where the hands are in a scene's array, which objects they touch, and who is told. On the update
/// thread.
class HandTracker
{
public:
    void setSource(HandSource* source) { _source = source; }
    HandSource* source() const { return _source; }

    void setCallback(TouchCallback* callback) { _callback = callback; }
    TouchCallback* callback() const { return _callback; }

    void setObstacles(const std::vector<Obstacle>& obstacles) { _obstacles = obstacles; }
    const std::vector<Obstacle>& obstacles() const { return _obstacles; }

    /// Plays \a uri where the application has set no source; a recording is read on a thread of its
    /// own. Returns what is wrong with it, once, or an empty text; what is wrong with a recording
    /// is a message.
    std::string setSettings(const std::string& uri, double reach_m, bool shadows);

    const std::string& uri() const { return _uri; }

    /// What the source wants the user to know since the last call.
    std::vector<std::string> takeMessages();

    /// Where hands are now, as the hologram thread wants them. \a worldToArray: world in metres ->
    /// array.
    void locate(double time_s,
                const Eigen::Isometry3d& worldToArray,
                midair::bridge::HandsAndObstacles& around);

    /// What they touch of \a objects. Events are kept until tell(). \a newest: the last field, or
    /// null.
    void touch(const std::vector<midair::bridge::HapticObject>& objects,
               const midair::bridge::HologramResult* newest);

    /// Where hands come from; null: nowhere.
    HandSource* active() const { return _source ? _source.get() : _namedSource.get(); }

    bool hasEvents() const { return !_proximity.events().empty(); }

    /// Calls callbacks; they may do anything with the scene, so it is done last. \a nodeOf gives an
    /// object's node or null. \a arrayToScene: array -> world in scene units.
    void tell(const std::function<osg::Node*(std::uint64_t)>& nodeOf,
              const Eigen::Affine3d& arrayToScene);

    /// Where the hands are, and what they are near of objects with touch events on; array frame.
    const midair::bridge::HandFrame& frame() const { return _frame; }
    const std::vector<midair::bridge::HandContact>& contacts() const
    {
        return _proximity.contacts();
    }

    int hands() const { return static_cast<int>(_frame.hands.size()); }
    int touching() const;

private:
    osg::ref_ptr<HandSource> _source;      ///< the application's
    osg::ref_ptr<HandSource> _namedSource; ///< that of the settings
    std::string _uri;
    double _reach_m = 0.0;
    bool _shadows = false;
    osg::ref_ptr<TouchCallback> _callback;
    std::vector<Obstacle> _obstacles;

    std::vector<Hand> _hands;
    midair::bridge::HandFrame _frame; ///< array frame
    midair::bridge::HandProximity _proximity;
    std::vector<midair::bridge::HapticObject> _touchable; ///< objects with touch events on
};

} // namespace osgMidair
