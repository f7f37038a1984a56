#pragma once

#include "engine-bridge/pipeline/HologramPipeline.h"
#include "tests/referee/Recorded.h"

#include <memory>
#include <string>
#include <vector>

namespace midair::referee
{

/// A scene's mesh on its way through the live pipeline.
class PipelineRun
{
public:
    /// Opens the device of \a uri. \a recorded gets the scene's constants here and an update from
    /// each call; it must outlive the run.
    PipelineRun(const Scene& scene, const std::string& uri, Recorded& recorded);

    void update(int k, const Eigen::Isometry3d& motion);

    /// What the results say is played, for each update. Where that is several fields, the file has
    /// them as often as there was time.
    const std::vector<std::vector<device::DriveSignal>>& claims() const { return _claims; }

private:
    using Result = std::shared_ptr<const bridge::HologramResult>;

    bridge::HologramOptions options(const std::string& uri);
    void keep(const Result& result, bool isJoined);
    void waitForFields(std::uint64_t takenBefore) const;
    void restUntilJoined();
    void waitForSurface();
    int rowsOf(const haptics::ControlPoints& part, std::size_t place);
    std::uint64_t taken() const;

    const Scene& _scene;
    Recorded& _recorded;
    const device::ArrayDevice* _device = nullptr;
    std::unique_ptr<bridge::HologramPipeline> _pipeline;
    bridge::HapticObject _object;
    Result _last;
    Eigen::Isometry3d _assembledAt = Eigen::Isometry3d::Identity(); // pose of _last
    std::vector<Eigen::Matrix3Xd> _sets; // of the cycle so far, in the mesh's frame
    std::vector<std::vector<device::DriveSignal>> _claims;
};

} // namespace midair::referee
