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

/// Hands that an OpenXR runtime tracks now, whatever the time asked for.
class OpenXrHandSource : public HandSource
{
public:
    /// Turns OpenXR's axes (x right, y up, z to the back) into OSG's (x right, y ahead, z up), with
    /// the same origin.
    static Eigen::Isometry3d upright();

    /// \a placement goes from OpenXR's space to the world of the scene, in metres. Returns at once;
    /// whatever keeps hands from being tracked is told as a message.
    explicit OpenXrHandSource(const OpenXrOptions& options,
                              const Eigen::Isometry3d& placement = upright());

    bool frameAt(double time_s, HandFrame& frame) override;
    std::string status() const override { return _tracker->status(); }

    /// What the user should know and has not been told; each is said once.
    std::vector<std::string> takeMessages() { return _tracker->messages(_told); }

private:
    std::shared_ptr<OpenXrTracker> _tracker;
    Eigen::Isometry3d _placement;
    std::size_t _told = 0;
};

} // namespace midair::bridge
