#include "device/autd3/Opening.h"
#include "device/autd3/protocol/Levels.h"
#include "haptics/base/threads/SteadyClock.h"

#include <algorithm>

#include <fmt/format.h>

namespace midair::device::autd3
{

namespace
{

constexpr int kSetUpTries = 3;
constexpr int kSettlings = 10; ///< of all commands, as a network that loses one in thirty needs
constexpr double kSetUpAnswer_s = 0.05;
constexpr double kSettingUp_s = 3; // all units' settings
constexpr int kFirmwareMajor = 0;
constexpr int kFirmwareMinor = 10;

} // namespace

bool isKnownFirmware(const FirmwareVersion& version)
{
    return version.major == kFirmwareMajor && version.minor == kFirmwareMinor;
}

std::string unknownFirmware(const std::string& who, const FirmwareVersion& version)
{
    return fmt::format("{} has firmware {}; this program speaks to {}.{}",
                       who,
                       version.text(),
                       kFirmwareMajor,
                       kFirmwareMinor);
}

// A unit keeps frames of a session before, and does them first.
void Opening::reset(const Unit& unit)
{
    constexpr std::uint8_t kAfterReset = 0xFF;
    const auto bytes = frame(nextNumber(), 0, Command::reset());
    for (int i = 0; i < kSetUpTries; ++i) // the same bytes: done once
    {
        const Answers answers = ask(&unit.at, bytes, kSetUpAnswer_s, 1);
        if (answers.empty()) continue;
        const Answer& answer = answers.front().second;
        if (answer.status == 0 && answer.reply.acknowledged == kAfterReset &&
            answer.reply.result == DONE && answer.reply.id == unit.id)
            return;
        throw error(fmt::format("unit {} can't be reset: {}",
                                unit.id,
                                answer.status != 0 ? statusText(answer.status)
                                                   : resultText(answer.reply.result)));
    }
    throw error(fmt::format("unit {} can't be reset: it doesn't answer", unit.id));
}

void pushSetUp(UnitGroup& group, int k, const Autd3Options& options)
{
    group.push(k, Command::clear());
    group.push(k, Command::synchronize());
    group.push(k, Command::configureCpu(options.cpu()));
    group.push(k, Command::setSilencer(options.silencer));
    group.push(k, Command::setPulseWidths(dutyWidths()));
    group.push(k, Command::setOutputMask(options.silent[static_cast<std::size_t>(k)]));
}

void Opening::settle(UnitGroup& group, std::vector<UnitGroup::Outcome>& outcomes)
{
    const double until_s = base::steadySeconds() + kSettingUp_s;
    while (!group.isIdle())
    {
        const double now_s = base::steadySeconds();
        if (_isLeft()) throw error("closed while it was opened");
        group.pump(now_s);
        group.receive(std::min(group.due_s(), now_s + kSetUpAnswer_s));
        for (UnitGroup::Outcome& outcome : group.takeOutcomes())
            outcomes.push_back(std::move(outcome));
        for (int k = 0; k < group.size(); ++k)
            if (!group.isThere(k))
                throw error(fmt::format("unit {} {}", k, group.unit(k).lost));
            else if (now_s > until_s && !group.unit(k).queue.isIdle())
                throw error(fmt::format("unit {} doesn't take its settings", k));
    }
}

std::string Opening::whyNot(const UnitGroup::Outcome& outcome)
{
    FirmwareInfo info;
    if (!readFirmwareInfo(outcome.done.data, info))
        return fmt::format("unit {} doesn't say what firmware it has", outcome.unit);
    for (const FirmwareVersion& version : {info.cpu, info.fpga})
        if (!isKnownFirmware(version))
            return fmt::format(
                "unit {} has firmware {} (CPU) and {} (FPGA); this program speaks to "
                "{}.{}",
                outcome.unit,
                info.cpu.text(),
                info.fpga.text(),
                kFirmwareMajor,
                kFirmwareMinor);
    _firmware = info.cpu.text();
    return {};
}

// A unit that took a command and whose answer was lost, or is wrong, is sent them all again.
void Opening::settleAll(UnitGroup& group, const std::function<void(int)>& push)
{
    std::string why = "the network loses so many answers that nobody knows how the units are set";
    std::vector<bool> isOpen(static_cast<std::size_t>(group.size()), true);
    for (int i = 0; i < kSettlings; ++i)
    {
        for (int k = 0; k < group.size(); ++k)
            if (isOpen[static_cast<std::size_t>(k)]) push(k);
        std::vector<UnitGroup::Outcome> outcomes;
        settle(group, outcomes);
        std::fill(isOpen.begin(), isOpen.end(), false);
        for (const UnitGroup::Outcome& outcome : outcomes)
        {
            std::string wrong;
            const bool isKnown = outcome.done.result.has_value();
            if (isKnown && *outcome.done.result != DONE)
                wrong = fmt::format("unit {} refuses command {:02X}: {}",
                                    outcome.unit,
                                    outcome.done.code,
                                    resultText(*outcome.done.result));
            else if (isKnown && outcome.done.code == kReadFirmwareCode)
                wrong = whyNot(outcome);
            if (!wrong.empty()) why = wrong;
            if (!isKnown || !wrong.empty()) isOpen[static_cast<std::size_t>(outcome.unit)] = true;
        }
        if (std::find(isOpen.begin(), isOpen.end(), true) == isOpen.end()) return;
    }
    throw error(why);
}

// Firmware is looked at before anything is set.
void Opening::setUp(UnitGroup& group)
{
    for (int k = 0; k < group.size(); ++k)
        reset(group.unit(k));
    settleAll(group, [&](int k) { group.push(k, Command::readFirmware()); });
    settleAll(group, [&](int k) { pushSetUp(group, k, _options); });
}

} // namespace midair::device::autd3
