#pragma once

#include "engine-bridge/HapticObject.h"
#include "engine-bridge/hands/HandProximity.h"
#include "engine-bridge/hands/HandSource.h"
#include "engine-bridge/hands/prediction/HandPredictor.h"
#include "engine-bridge/hands/tracking/NamedSource.h"
#include "haptics/base/text/MessageLog.h"

#include <Eigen/Geometry>

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace midair::bridge
{

/// Tracks where the hands are in the array's frame and which objects they touch. For one thread.
class HandTracker
{
public:
    /// Opens the source that a URI names; null: none. Throws what is wrong with it.
    using Opener = std::function<std::shared_ptr<HandSource>(const std::string& uri)>;

    explicit HandTracker(Opener open);

    /// Sets a source of the program's, which is used in place of the one that is named; null: none.
    void setSource(std::shared_ptr<HandSource> source) { _source.set(std::move(source)); }

    /// Opens the source \a uri; a recording is read on a separate thread, and begins now. Returns
    /// what is wrong with \a uri, once per change, or an empty text; what is wrong with a recording
    /// comes as a message. A source of the application's that can't be made is tried again by
    /// locate(), with pauses from 1 s to 30 s; each try that fails is a message.
    std::string setNamed(const std::string& uri) { return _source.setNamed(uri); }
    const std::string& named() const { return _source.named(); }

    /// Sets how hands are predicted, and the tracker's own delay (s, >= 0).
    void setPrediction(PredictionMethod method, double trackerDelay_s);
    bool predicts() const { return _predictor.method() != PredictionMethod::OFF; }
    /// Sets the time from locate() to the drive signal, s, as it was measured.
    void setLatency(double latency_s) { _delay.latency_s = latency_s; }
    /// How far the hands of the last locate() were predicted from when they were seen, s; 0: they
    /// were not.
    double predictedBy_s() const { return _predictor.ahead_s(); }

    /// From the time of the hands that locate() gives to the sound, s; 0: they are predicted to it.
    double late_s() const { return predicts() ? 0.0 : _delay.total_s(); }

    /// Returns what has happened since the last call: what the source says, and hands that could
    /// not be predicted.
    std::vector<base::Message> takeMessages();
    /// Returns what is wrong with the source, and its hands, now.
    std::vector<base::Message> troubles() const;

    /// Finds the hands at \a time_s, or where they will be when sound that is made for them
    /// arrives. \a worldToArray: transform from the world of the sources, in metres, to the array.
    void locate(double time_s, const Eigen::Isometry3d& worldToArray);

    /// Sets what the hands of the next locate() push; in the world of the sources, metres.
    void setPresses(std::vector<HandPress> presses) { _presses = std::move(presses); }

    /// Finds which \a objects the hands touch. \a played: what is played at this moment, for their
    /// forces.
    void touch(const std::vector<HapticObject>& objects,
               std::shared_ptr<const PlayedPressure> played);

    /// Ends all touches, without events.
    void forgetTouches() { _proximity = std::make_unique<HandProximity>(); }

    /// Returns the source in use; null: none.
    const std::shared_ptr<HandSource>& active() const { return _source.active(); }

    /// The hands of the last locate(), array frame.
    const HandFrame& frame() const { return _frame; }
    /// Which objects with touch events on the last touch() found near, and what began and ended.
    const HandProximity& proximity() const { return *_proximity; }

private:
    bool leavesToTracker() const { return _predictor.method() == PredictionMethod::TRACKER; }

    NamedSource<HandSource> _source;
    HandPredictor _predictor;
    TrackedDelay _delay;
    std::string _impossible;         ///< what is wrong with a joint; empty: nothing
    std::vector<HandPress> _presses; ///< world of the sources
    HandFrame _frame;                ///< array frame
    std::unique_ptr<HandProximity> _proximity = std::make_unique<HandProximity>();
    std::vector<HapticObject> _touchable; ///< objects with touch events on
};

} // namespace midair::bridge
