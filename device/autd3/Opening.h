#pragma once

#include "device/autd3/Autd3Options.h"
#include "device/autd3/UnitGroup.h"

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace midair::device::autd3
{

/// Opens the units on a cable: assigns ids from the nearest on, starts their clock, and configures
/// each, silent. Waits for them; throws DeviceError with the problem, and also when \a isLeft
/// returns true.
class Opening
{
public:
    using IsLeft = std::function<bool()>;

    Opening(DatagramLink& link,
            Refusals& refusals,
            const Autd3Options& options,
            std::string device,
            IsLeft isLeft);

    std::unique_ptr<UnitGroup> open();

    /// Firmware version reported by the units, "0.10.0".
    const std::string& firmware() const { return _firmware; }

private:
    using Answers = std::vector<std::pair<Endpoint, Answer>>;

    /// A question and its expected answers.
    struct Question
    {
        const Endpoint* to; ///< null: the group
        Kind kind;
        std::uint16_t number;
    };

    DeviceError error(const std::string& what) const { return DeviceError(_device + ": " + what); }
    std::uint16_t nextNumber() { return ++_number; }
    /// Sends to \a to (null: the group), and returns the answers to this number that arrive within
    /// \a wait_s, at most \a enough.
    Answers ask(const Endpoint* to,
                const std::vector<std::uint8_t>& bytes,
                double wait_s,
                std::size_t enough);
    void pause(double wait_s);
    void take(const Endpoint& from,
              const std::vector<std::uint8_t>& bytes,
              const Question& question,
              Answers& answers);

    void forgetIds();
    void number();
    Endpoint discover(int k);
    Unit assign(int k, const Endpoint& at);
    bool hasId(const Endpoint& at, int k);
    bool unblock(const Unit& unit);
    void checkAll();
    void startClock();
    void setUp(UnitGroup& group);
    void reset(const Unit& unit);
    void settle(UnitGroup& group, std::vector<UnitGroup::Outcome>& outcomes);
    /// Sends a command to each unit until all have done it.
    void setAll(UnitGroup& group, const std::function<Command(int)>& command);
    /// Returns the reason why a unit's firmware is unusable; empty: it is usable.
    std::string whyNot(const UnitGroup::Outcome& outcome);
    void resetLeftover();

    DatagramLink& _link;
    Refusals& _refusals;
    const Autd3Options& _options;
    const std::string _device;
    const IsLeft _isLeft;
    std::uint16_t _number; ///< of the last message
    std::vector<Unit> _units;
    std::string _firmware;
};

/// Returns true for firmware versions whose commands this program supports.
bool isKnownFirmware(const FirmwareVersion& version);
/// "WHO has firmware 12.1.0; this program supports 0.10".
std::string unknownFirmware(const std::string& who, const FirmwareVersion& version);

} // namespace midair::device::autd3
