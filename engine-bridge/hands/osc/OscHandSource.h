#pragma once

#include "engine-bridge/hands/HandSource.h"
#include "engine-bridge/hands/osc/OscReceiver.h"

#include <Eigen/Geometry>

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

namespace midair::bridge
{

/// The hands that come by OSC now, whatever time is asked for.
class OscHandSource : public HandSource
{
public:
    /// \a placement maps the sender's space to the world of the scene, in metres. Throws
    /// base::InputError if \a options have no address.
    explicit OscHandSource(const OscOptions& options,
                           const Eigen::Isometry3d& placement = Eigen::Isometry3d::Identity());

    bool frameAt(double time_s, HandFrame& frame) override;
    std::string status() const override { return _receiver->status(); }

    std::vector<std::string> takeMessages() override { return _receiver->inbox().messages(_told); }

    const OscReceiver& receiver() const { return *_receiver; }

private:
    std::shared_ptr<OscReceiver> _receiver;
    Eigen::Isometry3d _placement;
    std::size_t _told = 0;
};

} // namespace midair::bridge
