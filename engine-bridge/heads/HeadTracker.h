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

/// The ears of a head at \a pose, whose frame's x is to its right: 8 cm to the left and to the
/// right of the midpoint between the eyes; columns, as \a pose maps.
Eigen::Matrix<double, 3, 2> earsOf(const Eigen::Isometry3d& pose);

/// Tracks where the head is, in the world of the sources. For one thread.
class HeadTracker
{
public:
    /// Opens the source that a text names; null: none. Throws what is wrong with it.
    using Opener = std::function<std::shared_ptr<HeadSource>(const std::string& text)>;

    explicit HeadTracker(Opener open);

    /// \{ As of HandTracker. Another source than before forgets where the head was.
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

    /// Finds the head at \a time_s, or where it will be when sound that is made then arrives.
    void locate(double time_s);

    /// The head of the last locate().
    const Head& head() const { return _head; }
    /// Where it is, and after it was lost where it was last; none: it was never seen.
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
    std::string _impossible; ///< what is wrong with the head; empty: nothing
};

} // namespace midair::bridge
