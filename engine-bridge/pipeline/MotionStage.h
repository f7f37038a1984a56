#pragma once

#include "engine-bridge/display/Coincidence.h"
#include "engine-bridge/pipeline/MotionErrors.h"
#include "engine-bridge/pipeline/ObjectMotion.h"
#include "engine-bridge/pipeline/PipelineStage.h"
#include "haptics/base/threads/Mutex.h"

#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <vector>

namespace midair::bridge
{

/// Plays moving objects where they are seen when the sound arrives: extrapolates them by the time
/// between the frame's light (SceneSnapshot::lightAfter_s) and its sound. The time that the
/// snapshot has waited is known; the remaining work is assumed to take the median of the last
/// fields. Objects at rest are played exactly where they are. Objects rendered by contacts follow
/// the hands, and stay where they are while these aren't predicted.
class MotionStage final : public PipelineStage
{
public:
    explicit MotionStage(const PipelineContext& context) : _context(context) {}

    bool arrive(const SceneSnapshot*& snapshot) override;
    /// Later output isn't work for a snapshot.
    RestStep attend(bool /*isPlaying*/) override
    {
        _work.since_s = 0.0;
        return {};
    }
    void report(HologramResult& result, bool isOtherField) override;

    /// The first kMostSeen objects of the newest snapshot, with the distance between where they
    /// were played and seen. Any thread.
    std::vector<SeenObject> seen() const;
    static constexpr std::size_t kMostSeen = 16;

private:
    struct Followed
    {
        ObjectMotion motion;
        MotionErrors errors;
        std::uint64_t frame = 0; ///< of _now, when it was last present
        std::uint64_t meshId = 0;
        ObjectMotion::Corners corners = ObjectMotion::Corners::Zero(); ///< of the mesh's box
        bool isMeasured = false;
        Eigen::Vector3d played = Eigen::Vector3d::Zero(); ///< the box's middle, as played
    };
    /// Duration of the work for the last fields, from the snapshot's arrival to the device.
    struct Work
    {
        static constexpr std::size_t kMost = 32;
        std::vector<double> last_s; ///< a ring
        std::size_t count = 0;
        double since_s = 0.0; ///< start of the running work; 0: none
    };
    /// The newest snapshot.
    struct Now
    {
        std::uint64_t frame = 0; ///< counted here
        double time_s = 0.0;     ///< see passTime()
        double steady_s = 0.0;
        double simulation_s = 0.0;
        double lightAfter_s = 0.0;
    };
    struct Seen
    {
        mutable base::Mutex mutex;
        std::vector<SeenObject> objects MIDAIR_GUARDED_BY(mutex);
    };

    void passTime(const SceneSnapshot& snapshot);
    double ahead_s() const;
    bool isTouched(const HapticObject& object) const;
    static void measure(const HapticObject& object, Followed& of);
    Eigen::Isometry3d
    poseOf(const HapticObject& object, const SceneSnapshot& snapshot, double ahead_s, bool isSeen);
    void noteSeen(const SceneSnapshot& snapshot);

    const PipelineContext& _context;
    std::unordered_map<std::uint64_t, Followed> _objects; ///< by HapticObject::id
    Now _now;
    Work _work;
    SceneSnapshot _moved; ///< the newest, with other poses
    Seen _seen;
};

} // namespace midair::bridge
