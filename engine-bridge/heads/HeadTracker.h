#pragma once

#include "engine-bridge/hands/prediction/HandPredictor.h"
#include "engine-bridge/hands/tracking/NamedSource.h"
#include "engine-bridge/heads/HeadSource.h"
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

/// Returns the ears of a head at \a pose, whose frame's x points right: 8 cm to the left and to the
/// right of the midpoint between the eyes; columns, mapped by \a pose.
Eigen::Matrix<double, 3, 2> earsOf(const Eigen::Isometry3d& pose);

/// Tracks the head in the world of the sources. For one thread.
class HeadTracker
{
public:
    /// Opens a source by its text; null: none. Throws on errors.
    using Opener = std::function<std::shared_ptr<HeadSource>(const std::string& text)>;

    explicit HeadTracker(Opener open);

    /// \{ See HandTracker. A change of the source forgets the last place.
    void setSource(std::shared_ptr<HeadSource> source);
    std::string setNamed(const std::string& text);
    const std::string& named() const { return _source.named(); }
    const std::shared_ptr<HeadSource>& active() const { return _source.active(); }
    void setPrediction(PredictionMethod method, double trackerDelay_s);
    void setLatency(double latency_s) { _delay.latency_s = latency_s; }
    std::vector<base::Message> takeMessages();
    std::vector<base::Message> troubles() const;
    std::string status() const { return _source.status(); } ///< empty: there is none
    /// \}

    /// Locates the head at \a time_s, or predicts it to the time when sound made then arrives.
    void locate(double time_s);

    /// The head of the last locate().
    const Head& head() const { return _head; }
    /// Its place, and after a loss the last one; none: never seen.
    const std::optional<Eigen::Isometry3d>& lastPlace() const { return _last; }

private:
    bool leavesToTracker() const { return _predictor.method() == PredictionMethod::TRACKER; }
    void predict(double horizon_s);
    void forget(const HeadSource* before);

    NamedSource<HeadSource> _source;
    HandPredictor _predictor; ///< of a palm that moves as the head does
    TrackedDelay _delay;
    Head _head;
    std::optional<Eigen::Isometry3d> _last;
    std::string _impossible; ///< problem of the head; empty: none
};

} // namespace midair::bridge
