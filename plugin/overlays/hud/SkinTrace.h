#pragma once

#include "engine-bridge/pipeline/HologramResult.h"
#include "engine-bridge/playing/PlayedDrives.h"

#include <Eigen/Core>

#include <future>
#include <memory>

namespace osgMidair
{

class HapticEngine;

/// The recent radiation pressure on the skin.
struct SkinCurve
{
    double duration_s = 0.0;     ///< from the first value to the last; 0: there is no curve
    Eigen::VectorXd pressure_Pa; ///< n >= 2, evenly over the duration; empty: no curve
};

/// Returns the curve at the focus of \a result with the largest wanted pressure, from the drives
/// that the device has \a played, or if these are unknown from ContactScene::recent: with the
/// ringing of the array's transducers and the travel time of sound, by PressureProbe. Omits the
/// first 2 ms of recent fields, in which the sound of earlier ones would arrive. Empty without a
/// contact, and if fields are too few or not of the array.
SkinCurve skinCurveOf(const midair::bridge::HologramResult& result,
                      const midair::bridge::PlayedDrives& played = {});

/// Keeps the newest skin curve, computed on a separate thread at most ten times a second. All
/// functions are called on the update thread and don't block.
class SkinTrace
{
public:
    /// Starts a new curve of \a result (may be null) if none is in progress and the last one
    /// started long enough before \a now_s, steady clock. \a engine: its player; null: none.
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
