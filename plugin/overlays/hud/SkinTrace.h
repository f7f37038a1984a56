#pragma once

#include "engine-bridge/pipeline/HologramResult.h"
#include "engine-bridge/playing/PlayedDrives.h"

#include <Eigen/Core>

#include <future>
#include <memory>

namespace osgMidair
{

class HapticEngine;

/// The radiation pressure on the skin over the last moments.
struct SkinCurve
{
    double duration_s = 0.0;     ///< from the first value to the last; 0: there is no curve
    Eigen::VectorXd pressure_Pa; ///< n >= 2, evenly over the duration; empty: no curve
};

/// Returns the curve at the focus of \a result that most is wanted of, of what the device has
/// \a played, or where that isn't known of ContactScene::recent: with the ringing of the array's
/// transducers and the way of the sound, by PressureProbe. Of recent fields the first 2 ms are left
/// out, in which the sound of those from before would arrive. Empty where nothing is touched and
/// where fields are too few or not of the array.
SkinCurve skinCurveOf(const midair::bridge::HologramResult& result,
                      const midair::bridge::PlayedDrives& played = {});

/// Keeps the newest skin curve, computed in a thread of its own ten times a second at most. All
/// functions are called on the update thread and wait for nothing.
class SkinTrace
{
public:
    /// Begins a new curve of \a result (may be null) if there is none under way and the last was
    /// begun long enough before \a now_s, steady clock. \a engine: that plays it; null: none does.
    void update(const std::shared_ptr<const midair::bridge::HologramResult>& result,
                const HapticEngine* engine,
                double now_s);
    const SkinCurve& curve() const { return _curve; }

private:
    std::future<SkinCurve> _coming;
    SkinCurve _curve;
    double _begun_s = -1.0;
};

} // namespace osgMidair
