#pragma once

#include "device/autd3/DatagramLink.h"
#include "device/autd3/emulator/EmulatedChain.h"
#include "device/autd3/emulator/EmulatedTime.h"

#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>

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
    auto with(const Use& use)
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        const Time_ns now_ns = _time->now_ns();
        _chain.advance(now_ns);
        _changed.notify_all();
        return use(_chain, now_ns);
    }

private:
    friend class EmulatedLink;

    const std::shared_ptr<EmulatedTime> _time;
    std::mutex _mutex;
    std::condition_variable _changed;
    EmulatedChain _chain;
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

    std::shared_ptr<EmulatedUnits> _units;
    bool _woken = false;   ///< with the units' mutex
    bool _refused = false; ///< a send() found no room
};

} // namespace midair::device::emulation
