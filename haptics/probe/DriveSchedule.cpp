#include "haptics/probe/DriveSchedule.h"

#include "haptics/base/InputError.h"

#include <cmath>
#include <cstdint>

#include <fmt/format.h>

namespace midair::haptics
{

namespace
{

constexpr int kMostRepeated = 65536;
constexpr double kMostSteps = 1e7;    // 240 MB of them
constexpr double kLongest_s = 3600.0; // of a schedule that doesn't repeat
constexpr double kRunUp_s = 20.0 * kMostRinging_s;

std::string wrongStep(const ScheduledDrive& step, std::size_t drives)
{
    if (step.drive < 0 || static_cast<std::size_t>(step.drive) >= drives)
        return fmt::format("plays drive {}, but there are {}, from 0", step.drive, drives);
    if (!(step.amplitude >= 0.0 && step.amplitude <= 1.0))
        return fmt::format("has the amplitude {:g}; it must be within 0 .. 1", step.amplitude);
    if (!(step.duration_s > 0.0) || !std::isfinite(step.duration_s))
        return fmt::format("lasts {:g} s; it must be above 0", step.duration_s);
    return {};
}

} // namespace

double DriveSchedule::duration_s() const
{
    double sum_s = 0.0;
    for (const ScheduledDrive& step : steps)
        sum_s += step.duration_s;
    return sum_s;
}

bool DriveSchedule::isValid(std::string* error) const
{
    std::string text;
    if (drives.empty() || steps.empty())
        text = "there are no drives or no steps; there must be at least one of each";
    else if (!std::isfinite(begin_s))
        text = fmt::format("it begins at {:g} s; it must begin at a time", begin_s);
    for (std::size_t k = 0; k < drives.size() && text.empty(); ++k)
        if (drives[k].size() != drives.front().size())
            text = fmt::format("drive {} is for {} transducers, drive 0 for {}",
                               k,
                               drives[k].size(),
                               drives.front().size());
        else if (!drives[k].allFinite())
            text = fmt::format("an activation of drive {} is not finite", k);
    for (std::size_t k = 0; k < steps.size() && text.empty(); ++k)
        if (const std::string wrong = wrongStep(steps[k], drives.size()); !wrong.empty())
            text = fmt::format("step {} {}", k, wrong);
    if (error != nullptr) *error = text;
    return text.empty();
}

DriveSchedule stepsOf(const FieldSequence& sequence, double until_s)
{
    if (sequence.isEmpty())
        throw base::InputError("schedule: there are no fields; there must be at least one");
    if (!(until_s >= 0.0 && until_s <= kLongest_s))
        throw base::InputError(
            fmt::format("schedule: {:g} s are asked for; it must be 0 .. 3600 s", until_s));
    const Modulator modulator(sequence.modulation);
    const int fields = static_cast<int>(sequence.fields.size());
    const double rate_Hz = sequence.modulation.fieldRate_Hz;
    DriveSchedule schedule;
    schedule.drives = sequence.fields;
    std::vector<Modulator::Step> steps = modulator.pattern(fields, kMostRepeated);
    if (steps.empty())
    {
        const double runUp = std::ceil(kRunUp_s * rate_Hz);
        const double count = runUp + std::ceil(until_s * rate_Hz) + 1.0;
        if (count > kMostSteps)
            throw base::InputError(fmt::format("schedule: {:g} s at {:g} fields/s are more than "
                                               "{:g} steps, which is the most possible",
                                               until_s,
                                               rate_Hz,
                                               kMostSteps));
        const auto first = -static_cast<std::int64_t>(runUp);
        schedule.repeats = false;
        schedule.begin_s = -runUp / rate_Hz;
        steps = modulator.steps(first, static_cast<std::int64_t>(count), fields);
    }
    for (const Modulator::Step& step : steps)
        schedule.steps.push_back({step.field, step.amplitude, 1.0 / rate_Hz});
    return schedule;
}

} // namespace midair::haptics
