#include "engine-bridge/playing/PlayedDrives.h"
#include "engine-bridge/scene/Convert.h"
#include "haptics/base/ThrownBy.h"
#include "plugin/engine/SceneAccess.h"

#include <osgMidair/HapticScene>
#include <osgMidair/PlayedPressure>

namespace osgMidair
{

namespace
{

constexpr double kLongest_s = 0.1; // the maximum of ArrayDevice::playedSince()

} // namespace

std::vector<float>
playedPressure(const HapticScene& scene, const osg::Vec3d& place, double duration_s, double rate_Hz)
{
    namespace bridge = midair::bridge;
    const auto result = SceneAccess::latestResult(scene);
    if (!(duration_s > 0.0 && duration_s <= kLongest_s) || !result || !result->array) return {};
    const bridge::PlayedDrives played = SceneAccess::engine(scene).playedOfLate(duration_s);
    const Eigen::Vector3d there = Eigen::Affine3d(result->worldToArray) * bridge::toEigen(place);
    std::vector<float> pressure_Pa;
    // A place that can't be probed has no values.
    midair::base::thrownBy(
        [&]
        {
            const midair::haptics::PressureProbe probe(
                *result->array, result->medium, bridge::scheduleOf(played));
            const Eigen::VectorXd values_Pa = midair::haptics::radiationOf(
                probe.at(there, bridge::lastMoments(duration_s, rate_Hz)), result->medium);
            pressure_Pa.assign(values_Pa.begin(), values_Pa.end());
        });
    return pressure_Pa;
}

} // namespace osgMidair
