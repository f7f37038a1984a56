#pragma once

#include "device/autd3/DatagramLink.h"
#include "device/autd3/emulator/EmulatedChain.h"
#include "device/autd3/emulator/EmulatedTime.h"
#include "haptics/base/threads/Mutex.h"

#include <functional>
#include <memory>

namespace midair::device::emulation
{

/// Units in this program. All members may be called from any thread.
class EmulatedUnits
{
public:
    explicit EmulatedUnits(
        const ChainOptions& options,
        const std::shared_ptr<EmulatedTime>& time = std::make_shared<EmulatedTime>()) :
        _time(time),
        _chain(options, time->now_ns())
    {
    }

    /// Calls \a use with the chain, up to date, and the time, and wakes who waits for answers.
    template<typename Use>
    auto with(const Use& use) MIDAIR_EXCLUDES(_mutex)
    {
        const base::Lock lock(_mutex);
        const Time_ns now_ns = advance();
        return use(_chain, now_ns);
    }

private:
    friend class EmulatedLink;

    Time_ns advance() MIDAIR_REQUIRES(_mutex)
    {
        const Time_ns now_ns = _time->now_ns();
        _chain.advance(now_ns);
        _changed.notifyAll();
        return now_ns;
    }

    const std::shared_ptr<EmulatedTime> _time;
    base::Mutex _mutex;
    base::Condition _changed;
    EmulatedChain _chain MIDAIR_GUARDED_BY(_mutex);
};

/// A link to units in this program. Their addresses are those of real ones.
class EmulatedLink : public autd3::DatagramLink
{
public:
    explicit EmulatedLink(std::shared_ptr<EmulatedUnits> units) : _units(std::move(units)) {}

    std::string name() const override { return "emulated"; }
    double now_s() const override { return static_cast<double>(_units->_time->now_ns()) * 1e-9; }
    bool send(const autd3::Endpoint& to, const std::vector<std::uint8_t>& bytes) override;
    bool sendToGroup(const std::vector<std::uint8_t>& bytes) override;
    bool receive(double until_s, autd3::Endpoint& from, std::vector<std::uint8_t>& bytes) override;
    void rest(double until_s) override;
    void wake() override;

    static autd3::Endpoint addressOf(int id); ///< of a unit; -1: of somebody who is none

private:
    bool send(int to, const std::vector<std::uint8_t>& bytes);

    const std::shared_ptr<EmulatedUnits> _units;
    bool _woken MIDAIR_GUARDED_BY(_units->_mutex) = false;
    bool _refused MIDAIR_GUARDED_BY(_units->_mutex) = false; ///< a send() found no room
};

} // namespace midair::device::emulation
