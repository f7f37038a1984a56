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
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace midair::bridge
{

/// Tracks the hands in the array's frame and the objects that they touch. For one thread.
class HandTracker
{
public:
    /// Opens a source by its URI; null: none. Throws on errors.
    using Opener = std::function<std::shared_ptr<HandSource>(const std::string& uri)>;

    explicit HandTracker(Opener open);

    /// Sets a source of the program, which replaces the named one; null: none.
    void setSource(std::shared_ptr<HandSource> source) { _source.set(std::move(source)); }

    /// Opens the source \a uri; a recording is read on a separate thread, and begins now. Returns
    /// the error of \a uri, once per change, or an empty text; errors of a recording come as
    /// messages. locate() retries an application's source that can't be made, with pauses from 1 s
    /// to 30 s; each failure is reported.
    std::string setNamed(const std::string& uri) { return _source.setNamed(uri); }
    const std::string& named() const { return _source.named(); }

    /// Sets the prediction method, and the tracker's own delay (s, >= 0).
    void setPrediction(PredictionMethod method, double trackerDelay_s);
    bool predicts() const { return _predictor.method() != PredictionMethod::OFF; }
    /// Sets the measured time from locate() to the drive signal, s.
    void setLatency(double latency_s) { _delay.latency_s = latency_s; }
    /// Longest prediction of the last locate(), s, from when the hand was seen; 0: none.
    double predictedBy_s() const { return _predictor.ahead_s(); }

    /// Time from the hands of locate() to the sound, s; 0: they are predicted to it.
    double late_s() const { return predicts() ? 0.0 : _delay.total_s(); }

    /// Returns new messages: of the source, and about hands that could not be predicted.
    std::vector<base::Message> takeMessages();
    /// Returns the present problems of the source and its hands.
    std::vector<base::Message> troubles() const;

    /// Locates the hands at \a time_s, or predicts them to the time when sound made for them
    /// arrives. \a worldToArray: transform from the world of the sources, in metres, to the array.
    void locate(double time_s, const Eigen::Isometry3d& worldToArray);

    /// Sets the pushes of the hands of the next locate(); in the world of the sources, metres.
    void setPresses(std::vector<HandPress> presses) { _presses = std::move(presses); }

    /// Finds which \a objects the hands touch. \a played: the field played now, for their forces.
    void touch(const std::vector<HapticObject>& objects,
               std::shared_ptr<const PlayedPressure> played);

    /// Ends all touches, without events.
    void forgetTouches() { _proximity = std::make_unique<HandProximity>(); }

    /// Returns the source in use; null: none.
    const std::shared_ptr<HandSource>& active() const { return _source.active(); }

    /// The hands of the last locate(), array frame.
    const HandFrame& frame() const { return _frame; }
    /// The hands for drawing: at the frame's display time, if the source knows it; those of frame()
    /// are for the time when the sound arrives.
    const HandFrame& shown() const { return _isShown ? _shown : _frame; }
    /// Returns why the calibration of hands, head and picture is no longer valid; empty: valid. It
    /// ends when locate() is called with another transform, after a new calibration.
    static std::string recentred();
    /// Objects with touch events near the last touch(), and touches that began and ended.
    const HandProximity& proximity() const { return *_proximity; }

private:
    bool leavesToTracker() const { return _predictor.method() == PredictionMethod::TRACKER; }

    NamedSource<HandSource> _source;
    HandPredictor _predictor;
    TrackedDelay _delay;
    std::string _impossible;         ///< problem of a joint; empty: none
    std::vector<HandPress> _presses; ///< world of the sources
    HandFrame _frame;                ///< array frame
    HandFrame _shown;                ///< array frame
    bool _isShown = false;
    std::optional<Eigen::Isometry3d> _worldToArray; ///< of the last locate()
    std::unique_ptr<HandProximity> _proximity = std::make_unique<HandProximity>();
    std::vector<HapticObject> _touchable; ///< objects with touch events on
};

} // namespace midair::bridge
