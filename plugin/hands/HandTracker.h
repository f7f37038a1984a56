#pragma once

#include "engine-bridge/hands/HandProximity.h"
#include "engine-bridge/hands/prediction/HandPredictor.h"
#include "engine-bridge/pipeline/SceneSnapshot.h"
#include "haptics/base/text/MessageLog.h"

#include <osgMidair/HandSource>
#include <osgMidair/TouchCallback>

#include <osg/observer_ptr>

#include <Eigen/Geometry>

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace osgMidair
{

/// Tracks where the hands are in the array's frame and which objects they touch, and calls touch
/// callbacks. For the update thread only.
class HandTracker
{
public:
    void setSource(HandSource* source) { _source = source; }
    HandSource* source() const { return _source; }

    void setCallback(TouchCallback* callback) { _callback = callback; }
    TouchCallback* callback() const { return _callback; }

    void setObstacles(const std::vector<Obstacle>& obstacles) { _obstacles = obstacles; }
    const std::vector<Obstacle>& obstacles() const { return _obstacles; }

    /// Opens the source \a uri, which is used if the application has set no source; a recording is
    /// read on a separate thread. Returns what is wrong with \a uri, once per change, or an empty
    /// text; what is wrong with a recording comes as a message. A source of the application's that
    /// can't be made is tried again by locate(), with pauses from 1 s to 30 s; each try that fails
    /// is a message.
    std::string setSettings(const std::string& uri, double reach_m, bool shadows);

    const std::string& uri() const { return _uri; }

    /// Sets how hands are predicted, and the tracker's own delay (s, >= 0).
    void setPrediction(midair::bridge::PredictionMethod method, double trackerDelay_s);
    bool predicts() const { return _predictor.method() != midair::bridge::PredictionMethod::OFF; }
    /// Sets the time from locate() to the drive signal, s, as it was measured.
    void setLatency(double latency_s) { _latency_s = latency_s; }
    /// How far the hands of the last locate() were predicted from when they were seen, s; 0: they
    /// were not.
    double predictedBy_s() const { return _predictor.ahead_s(); }

    /// From the time of the hands that locate() gives to the sound, s; 0: they are predicted to it.
    double late_s() const { return predicts() ? 0.0 : horizon_s(); }

    /// Returns the messages of the source since the last call.
    std::vector<midair::base::Message> takeMessages();

    /// Fills \a around with the hands at \a time_s, or where they will be when sound that is made
    /// for them arrives, and the obstacles, in the array frame. \a worldToArray: transform from the
    /// world in metres to the array.
    void locate(double time_s,
                const Eigen::Isometry3d& worldToArray,
                midair::bridge::HandsAndObstacles& around);

    /// Finds which \a objects the hands touch; tell() then reports the events. \a played: what is
    /// played at this moment, for their forces.
    void touch(const std::vector<midair::bridge::HapticObject>& objects,
               std::shared_ptr<const midair::bridge::PlayedPressure> played);

    /// Returns the source in use; null: none.
    HandSource* active() const { return _source ? _source.get() : _namedSource.get(); }

    /// Returns true if gather() has something to do.
    bool hasEvents() const { return !_proximity.events().empty() || !_proximity.ongoing().empty(); }

    /// A touch that begins, goes on or ends.
    struct Told
    {
        midair::bridge::TouchEvent::Kind kind = midair::bridge::TouchEvent::ENTER;
        std::uint64_t object = 0;
        osg::ref_ptr<osg::Node> node; ///< keeps that of the touch
        Touch touch;
    };

    /// Returns what is to be told of the last touch(), and keeps current(). \a nodeOf returns the
    /// node of an object or null. \a arrayToScene: transform from the array to the world in scene
    /// units.
    std::vector<Told> gather(const std::function<osg::Node*(std::uint64_t)>& nodeOf,
                             const Eigen::Affine3d& arrayToScene);

    /// The touches that have begun and not ended, by the last gather().
    std::vector<Touch> current() const;

    /// Calls the callbacks. These may do anything with the scene, so call it last. Returns what
    /// they have thrown.
    std::vector<midair::base::Message> tell(const std::vector<Told>& all);

    /// The hands, and their contacts with objects that have touch events on; array frame.
    const midair::bridge::HandFrame& frame() const { return _frame; }
    const std::vector<midair::bridge::HandContact>& contacts() const
    {
        return _proximity.contacts();
    }

    int hands() const { return static_cast<int>(_frame.hands.size()); }
    int touching() const;

private:
    /// When a source that could not be made is tried again.
    struct Retry
    {
        double at_s = 0.0;    ///< steady clock
        double pause_s = 0.0; ///< before it; 0: never
    };

    /// What a source said when it was asked for hands of a later time.
    struct Later
    {
        enum Answer
        {
            NOT_ASKED,
            YES,
            NO
        };
        osg::observer_ptr<HandSource> source;
        Answer answer = NOT_ASKED;
    };

    std::string openNamed();
    void tryAgain();
    bool ask(double time_s);
    double horizon_s() const;
    bool leavesToTracker() const
    {
        return _predictor.method() == midair::bridge::PredictionMethod::TRACKER;
    }
    void askAhead(HandSource& source);
    midair::base::Message failureOf(const std::string& thrown) const;

    osg::ref_ptr<HandSource> _source;      ///< set by the application
    osg::ref_ptr<HandSource> _namedSource; ///< named by the settings
    std::string _uri;
    Retry _retry;
    std::string _failed; ///< the last of these tries; empty: none since the last message
    std::string _thrown; ///< by the source, in words; empty: nothing
    midair::bridge::HandPredictor _predictor;
    Later _later;
    bool _tellsNoLater = false; ///< a source has just said that it has none
    double _trackerDelay_s = 0.0;
    double _latency_s = 0.0; ///< from locate() to the drive signal
    std::string _impossible; ///< what is wrong with a joint; empty: nothing
    bool _isImpossibleTold = false;
    double _reach_m = 0.0;
    bool _shadows = false;
    osg::ref_ptr<TouchCallback> _callback;
    std::vector<Obstacle> _obstacles;

    std::vector<Hand> _hands;
    midair::bridge::HandFrame _frame; ///< array frame
    midair::bridge::HandProximity _proximity;
    std::vector<Told> _current;                           ///< begun and not ended
    std::vector<midair::bridge::HapticObject> _touchable; ///< objects with touch events on
};

} // namespace osgMidair
