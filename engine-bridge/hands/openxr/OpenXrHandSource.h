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

/// The hands that an OpenXR runtime tracks now, or predicts, for any requested time.
class OpenXrHandSource : public HandSource
{
public:
    /// The rotation from OpenXR's axes (x right, y up, z to the back) to OSG's (x right, y ahead, z
    /// up).
    static Eigen::Isometry3d upright();

    /// \a placement maps OpenXR's space to the scene's world, in metres. Doesn't wait for the
    /// runtime; if hands can't be tracked, takeMessages() returns the reason.
    explicit OpenXrHandSource(const OpenXrOptions& options,
                              const Eigen::Isometry3d& placement = upright());

    bool frameAt(double time_s, HandFrame& frame) override;
    bool shownFrame(HandFrame& frame) override;
    /// Requests predicted hands from the runtime; each source has its own horizon.
    bool setHorizon(double ahead_s) override;
    std::string status() const override { return _tracker->status(); }

    std::vector<std::string> takeMessages() override { return _tracker->messages(_told); }

private:
    std::shared_ptr<OpenXrTracker> _tracker;
    std::shared_ptr<OpenXrAsker> _asker;
    Eigen::Isometry3d _placement;
    std::size_t _told = 0;
};

} // namespace midair::bridge
