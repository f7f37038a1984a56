#pragma once

#include "engine-bridge/hands/HandSource.h"
#include "engine-bridge/hands/openxr/OpenXrTracker.h"

#include <Eigen/Geometry>

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

namespace midair::bridge
{

/// The hands that an OpenXR runtime tracks now, or that it predicts, whatever time is asked for.
class OpenXrHandSource : public HandSource
{
public:
    /// The rotation from OpenXR's axes (x right, y up, z to the back) to OSG's (x right, y ahead, z
    /// up).
    static Eigen::Isometry3d upright();

    /// \a placement maps OpenXR's space to the world of the scene, in metres. Doesn't wait for the
    /// runtime; if hands can't be tracked, takeMessages() returns the reason.
    explicit OpenXrHandSource(const OpenXrOptions& options,
                              const Eigen::Isometry3d& placement = upright());

    bool frameAt(double time_s, HandFrame& frame) override;
    /// The runtime is asked for the hands of so much later. Sources of one tracker share the newest
    /// horizon.
    bool setHorizon(double ahead_s) override;
    std::string status() const override { return _tracker->status(); }

    std::vector<std::string> takeMessages() override { return _tracker->messages(_told); }

private:
    std::shared_ptr<OpenXrTracker> _tracker;
    Eigen::Isometry3d _placement;
    std::size_t _told = 0;
};

} // namespace midair::bridge
