#include "engine-bridge/pipeline/HologramOptions.h"

#include "device/drive/DriveEncoder.h"
#include "engine-bridge/playing/PlayedDrives.h"
#include "haptics/base/InputError.h"
#include "haptics/base/Limits.h"
#include "haptics/base/settings/Setting.h"
#include "haptics/base/text/Number.h"
#include "haptics/base/text/Range.h"
#include "haptics/base/threads/ThreadPool.h"
#include "haptics/sequence/FieldSettings.h"

#include <algorithm>

#include <fmt/format.h>

namespace midair::bridge
{

namespace
{

constexpr int kMostFieldsInTurn = 256; // steps between them included

} // namespace

bool HologramOptions::isValid(std::string* error) const
{
    if (array.size() == 0)
    {
        if (error)
            *error = "array \"" + array.name + "\" has no transducers; it must have at least one";
        return false;
    }
    haptics::FieldSettings settings;
    base::assignPart<haptics::SequenceSettings>(settings, *this);
    base::assignPart<haptics::PlayingSettings>(settings, *this);
    // keepToLimits() corrects these two.
    settings.maxPoints = std::min(settings.maxPoints, base::kMostControlPoints);
    if (monitorInterval > 0.0)
        settings.monitorInterval = std::max(monitorInterval, base::kLeastMonitorInterval_s);
    base::RangeCheck check;
    return medium.isValid(error) && contacts.isValid(error) &&
           haptics::fieldSettings()
               .check(settings, check)
               .atLeast("reopen_s", reopen_s, 0.0)
               .require(restAfter_s >= 0.0, "restAfter_s is negative or not a number")
               .require(earPoints.allFinite(), "earPoints are not all finite")
               .passed(error) &&
           modulation.isValid(error) && solverOptions.isValid(error);
}

void keepToLimits(HologramOptions& options, base::MessageLog& messages)
{
    std::vector<base::Message> limited;
    int& threads = options.solverOptions.threads;
    const int cores = base::coreCount();
    if (threads > cores)
    {
        limited.push_back({base::MessageCode::SETTINGS_LIMITED,
                           fmt::format("threads is {}; this machine has {} {}: {} {} used",
                                       threads,
                                       cores,
                                       cores == 1 ? "core" : "cores",
                                       cores,
                                       cores == 1 ? "is" : "are")});
        threads = cores;
    }
    if (!options.solverOptions.pool)
        options.solverOptions.pool = std::make_shared<base::ThreadPool>(threads);
    const auto keepBelow =
        [&limited](const char* name, int& value, int most, const std::string& why)
    {
        if (value <= most) return;
        limited.push_back({base::MessageCode::SETTINGS_LIMITED,
                           fmt::format("{} is {}; {} at most {}", name, value, why, most)});
        value = most;
    };
    const auto transducers = static_cast<std::size_t>(options.array.size());
    const std::size_t most =
        std::min(std::size_t(base::kMostControlPoints), base::kMostEntries / transducers);
    keepBelow("maxPoints",
              options.maxPoints,
              std::max(1, static_cast<int>(most)),
              "the control points of a field of this array are");
    const std::string cycle = fmt::format("with a cycle of {} it is", options.cycle);
    keepBelow("subsets", options.subsets, kMostFieldsInTurn / options.cycle, cycle);
    keepBelow("cycleSteps", options.cycleSteps, kMostFieldsInTurn / options.cycle - 1, cycle);
    double& interval_s = options.monitorInterval;
    if (interval_s > 0.0 && interval_s < base::kLeastMonitorInterval_s)
    {
        limited.push_back(
            {base::MessageCode::SETTINGS_LIMITED,
             fmt::format("monitorInterval is {}; fields are checked every {:g} s at most",
                         base::exactNumber(interval_s),
                         base::kLeastMonitorInterval_s)});
        interval_s = base::kLeastMonitorInterval_s;
    }
    messages.sayNow({base::MessageCode::SETTINGS_LIMITED}, limited);
}

namespace
{

// With the limits of the URI only: those of the options may change while it is open.
std::unique_ptr<device::ArrayDevice>
openUnlimited(const std::string& uri, const device::DeviceLayout& layout, const std::string& owner)
{
    // It refuses fields, and ArrayOutput silences a device that refuses one, which would end it.
    if (device::playsByItself(uri))
        throw device::DeviceError(
            "device \"" + uri +
            "\": a recording can't play a scene; play it with midair-device play FILE");
    return device::openLimitedDevice(uri, layout, {}, owner);
}

} // namespace

void fillIn(HologramOptions& options)
{
    if (options.solver.empty()) options.solver = haptics::solverNames().front();
    options.solverOptions.updateRate_Hz = options.fieldRate;
    options.modulation.fieldRate_Hz = options.fieldRate;
    if (!options.solverFactory)
        options.solverFactory = [](const std::string& name, const haptics::SolverOptions& o)
        { return haptics::makeSolver(name, o); };
    if (!options.deviceFactory)
    {
        options.deviceFactory =
            [owner = options.owner](const std::string& uri, const device::DeviceLayout& layout)
        { return openUnlimited(uri, layout, owner); };
    }
    options.solverOptions.skipTolerance = options.motionTolerance;
}

void keepToLevels(HologramOptions& options, const device::DriveAbility& ability)
{
    haptics::DriveResolution& drive = options.array.drive;
    drive.phaseLevels = ability.phaseLevels;
    drive.amplitudeLevels =
        ability.amplitudes.empty() ? device::amplitudeLevels() : ability.amplitudes;
    options.array.ringing_s = simulatedRinging_s(options.array, ability);
}

base::CodedError noSolver(const std::string& name)
{
    return {base::MessageCode::SOLVER_UNKNOWN, "no solver \"" + name + "\"; nothing is played"};
}

haptics::ComposerOptions composerOptions(const HologramOptions& options)
{
    haptics::ComposerOptions composer;
    base::assignPart<haptics::SequenceSettings>(composer, options);
    composer.solverOptions = options.solverOptions;
    composer.modulation = options.modulation;
    composer.makeSolver = [&options]
    {
        auto made = options.solverFactory(options.solver, options.solverOptions);
        if (!made) throw noSolver(options.solver);
        return made;
    };
    return composer;
}

} // namespace midair::bridge
