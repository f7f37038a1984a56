#include "tests/benchmarks/headset/JointToDrive.h"

#include "haptics/base/Percentile.h"
#include "haptics/base/Units.h"
#include "haptics/base/threads/SteadyClock.h"
#include "tests/benchmarks/headset/Finger.h"
#include "tests/benchmarks/headset/Noted.h"

#include <cmath>
#include <cstdio>
#include <optional>
#include <vector>

namespace midair::bench
{

namespace
{

constexpr double kSpeed = 0.12; ///< m/s, of the finger at its fastest
constexpr double kWavelength_m = 343.2 / 40e3;
constexpr double kSlowest = 0.6; ///< of that speed; slower places tell the time badly
constexpr double kSame_s = 6e-4; ///< joints' times that differ by less are the same ones

/// When a swaying finger was where it was found.
class Sway
{
public:
    explicit Sway(double start_s) : _start_s(start_s) {}

    /// How old the joints at \a x_m (from the middle) are at \a now_s; nothing near the turns.
    std::optional<double> age_s(double x_m, double now_s) const
    {
        const double share = base::kPi * x_m / kSpeed;
        if (std::abs(share) > std::sqrt(1.0 - kSlowest * kSlowest)) return {};
        const double since = base::kPi * (now_s - _start_s);
        if (std::abs(std::cos(since)) < kSlowest) return {};
        const double angle =
            std::cos(since) > 0.0 ? std::asin(share) : base::kPi - std::asin(share);
        return std::remainder(since - angle, base::kTwoPi) / base::kPi;
    }
    double x_m(double time_s) const
    {
        return kSpeed / base::kPi * std::sin(base::kPi * (time_s - _start_s));
    }

private:
    double _start_s;
};

osg::ref_ptr<osgMidair::HapticScene> touchedBlock(const char* array)
{
    osg::ref_ptr<osgMidair::HapticScene> scene = new osgMidair::HapticScene;
    scene->setDevice("noted:");
    scene->setArray(array);
    scene->setHands("openxr:");
    scene->setRender(osgMidair::HapticSettings::CONTACT);
    scene->setPrediction(osgMidair::HapticSettings::OFF); // so that places tell the joints' times
    scene->setContactRate(0.0);
    scene->setContactFoci(1);
    scene->addChild(new osgMidair::HapticSurface(block(topIn(array)).get()));
    return scene;
}

struct Ages
{
    std::vector<double> first_ms; ///< of the first field that follows from joints
    std::vector<double> all_ms;   ///< of all fields
};

Ages agesOf(const std::vector<NotedDrive>& drives,
            const FocusFinder& finder,
            const Sway& sway,
            const Eigen::Vector3d& offset)
{
    Ages ages;
    double before_s = 0.0;
    bool wasSame = true;
    for (const NotedDrive& drive : drives)
    {
        const Eigen::Vector3d guess =
            offset + Eigen::Vector3d(sway.x_m(drive.time_s - 0.015), 0.0, 0.0);
        const auto found = finder.near(drive, guess);
        const auto age = found ? sway.age_s(found->x() - offset.x(), drive.time_s) : std::nullopt;
        if (!age) continue;
        ages.all_ms.push_back(1e3 * *age);
        const double joints_s = drive.time_s - *age;
        // Foci go to new joints in some small steps: the first field that stays.
        const bool isSame = std::abs(joints_s - before_s) < kSame_s;
        if (isSame && !wasSame) ages.first_ms.push_back(1e3 * *age);
        wasSame = isSame;
        before_s = joints_s;
    }
    return ages;
}

} // namespace

void printJointToDrive(const char* array, double seconds)
{
    useFakeRuntime();
    const double top_m = topIn(array);
    setFinger(top_m, 0.0);
    const auto scene = touchedBlock(array);
    const FocusFinder finder(haptics::TransducerArray::load(array), kWavelength_m);
    Frames90 frames(scene);
    std::vector<NotedDrive> still;
    for (int tries = 0; tries < 20 && (tries < 4 || still.empty()); ++tries)
    {
        takeDrives();
        frames.framesFor(0.5);
        still = takeDrives();
    }
    const auto offset = still.empty() ? std::nullopt : finder.near(still.back(), {0.0, 0.0, top_m});
    if (!offset)
    {
        std::printf("%-8s nothing was played: %s\n",
                    array,
                    scene->getStatistics().messages.empty()
                        ? "no reason is known"
                        : scene->getStatistics().messages.back().c_str());
        return;
    }
    setFinger(top_m, kSpeed);
    const Sway sway(1e-9 * static_cast<double>(FakeAccess()->start));
    frames.framesFor(1.0);
    takeDrives();
    frames.framesFor(seconds);
    const std::vector<NotedDrive> drives = takeDrives();
    const Ages ages = agesOf(drives, finder, sway, *offset);
    std::printf("%-8s first field of new joints p50 %5.1f ms, p95 %5.1f ms; all fields p50 %5.1f "
                "ms, p95 %5.1f ms; %4.0f fields a second, %zu timed\n",
                array,
                base::percentile(ages.first_ms, 0.5),
                base::percentile(ages.first_ms, 0.95),
                base::percentile(ages.all_ms, 0.5),
                base::percentile(ages.all_ms, 0.95),
                static_cast<double>(drives.size()) / seconds,
                ages.all_ms.size());
}

} // namespace midair::bench
