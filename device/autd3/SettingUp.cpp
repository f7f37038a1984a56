#include "device/autd3/Opening.h"
#include "device/autd3/protocol/Levels.h"

#include <algorithm>

#include <fmt/format.h>

namespace midair::device::autd3
{

namespace
{

constexpr int kSetUpTries = 3;
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

void Opening::settle(UnitGroup& group, std::vector<UnitGroup::Outcome>& outcomes)
{
    const double until_s = _link.now_s() + kSettingUp_s;
    while (!group.isIdle())
    {
        const double now_s = _link.now_s();
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

// One command at a time: so a unit answers to a repeat, whatever is lost, and its result is known.
// A unit whose answer is wrong is asked again.
void Opening::setAll(UnitGroup& group, const std::function<Command(int)>& command)
{
    std::string why;
    std::vector<bool> isOpen(static_cast<std::size_t>(group.size()), true);
    for (int i = 0; i < kSetUpTries; ++i)
    {
        for (int k = 0; k < group.size(); ++k)
            if (isOpen[static_cast<std::size_t>(k)]) group.push(k, command(k));
        std::vector<UnitGroup::Outcome> outcomes;
        settle(group, outcomes);
        std::fill(isOpen.begin(), isOpen.end(), false);
        for (const UnitGroup::Outcome& outcome : outcomes)
        {
            const std::uint8_t result = outcome.done.result.value_or(DONE);
            std::string wrong;
            if (!outcome.done.result)
                wrong = fmt::format("unit {} doesn't say what became of a command", outcome.unit);
            else if (result != DONE)
                wrong = fmt::format("unit {} refuses command {:02X}: {}",
                                    outcome.unit,
                                    outcome.done.code,
                                    resultText(result));
            else if (outcome.done.code == kReadFirmwareCode)
                wrong = whyNot(outcome);
            if (wrong.empty()) continue;
            why = wrong;
            isOpen[static_cast<std::size_t>(outcome.unit)] = true;
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
    for (const Command& command : {Command::readFirmware(),
                                   Command::clear(),
                                   Command::synchronize(),
                                   Command::configureCpu(_options.cpu()),
                                   Command::setSilencer(_options.silencer),
                                   Command::setPulseWidths(dutyWidths())})
        setAll(group, [&](int) { return command; });
    setAll(group,
           [&](int k)
           { return Command::setOutputMask(_options.silent[static_cast<std::size_t>(k)]); });
}

} // namespace midair::device::autd3
