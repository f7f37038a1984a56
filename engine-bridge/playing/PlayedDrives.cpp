#include "engine-bridge/playing/PlayedDrives.h"

#include "device/simulation/SimulatedArray.h"
#include "haptics/base/InputError.h"
#include "haptics/base/threads/SteadyClock.h"

#include <algorithm>

namespace midair::bridge
{

namespace
{

constexpr double kUnderWay_s = 3e-3;                          // over a metre of air
constexpr double kSettled_s = 40.0 * haptics::kMostRinging_s; // all ringing has ended

static_assert(device::kMostSimulatedRinging_s == haptics::kMostRinging_s);

} // namespace

PlayedDrives playedOf(const device::ArrayDevice& device, double duration_s)
{
    PlayedDrives played;
    played.until_s = base::steadySeconds();
    played.fields = device.playedSince(played.until_s - duration_s - kUnderWay_s);
    return played;
}

double simulatedRinging_s(const haptics::TransducerArray& array,
                          const device::DriveAbility& ability)
{
    return ability.ringing_s >= 0.0 ? ability.ringing_s : array.ringing_s;
}

haptics::DriveSchedule scheduleOf(const PlayedDrives& played)
{
    if (played.fields.empty())
        throw base::InputError(
            "the drives played by the array are unknown; only sim: reports them");
    haptics::DriveSchedule schedule;
    schedule.repeats = false;
    const std::vector<device::PlayedField>& fields = played.fields;
    const double first_s = std::min(fields.front().since_s, played.until_s) - kSettled_s;
    schedule.begin_s = first_s - played.until_s;
    for (std::size_t k = 0; k < fields.size(); ++k)
    {
        const bool isLast = k + 1 == fields.size();
        const double from_s = k == 0 ? first_s : fields[k].since_s;
        // The last one is held, as schedules that don't repeat do.
        const double until_s = isLast ? from_s + kUnderWay_s : fields[k + 1].since_s;
        if (!(until_s > from_s)) continue;
        schedule.steps.push_back({static_cast<int>(schedule.drives.size()), 1.0, until_s - from_s});
        schedule.drives.emplace_back(Eigen::Map<const Eigen::VectorXcf>(
            fields[k].q.data(), static_cast<Eigen::Index>(fields[k].q.size())));
    }
    return schedule;
}

haptics::ProbeOptions lastMoments(double duration_s, double rate_Hz)
{
    haptics::ProbeOptions when;
    when.rate_Hz = rate_Hz;
    when.duration_s = duration_s;
    when.begin_s = -duration_s;
    return when;
}

} // namespace midair::bridge
