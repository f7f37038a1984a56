#pragma once

#include "device/autd3/DatagramLink.h"
#include "device/autd3/emulator/EmulatedChain.h"
#include "device/autd3/emulator/unit/EmulatedClock.h"
#include "haptics/base/threads/Mutex.h"

#include <functional>
#include <memory>
#include <random>

namespace midair::device::emulation
{

/// Clock of emulated units and of threads that wait for them: base::steadySeconds(), in ns.
class EmulatedTime
{
public:
    virtual ~EmulatedTime() = default;
    virtual Time_ns now_ns() { return static_cast<Time_ns>(base::steadySeconds() * 1e9); }
    /// Waits until \a until_ns, \a changed, or sooner; \a lock holds \a mutex, which is released
    /// meanwhile.
    virtual void
    wait(base::Mutex& mutex, base::Lock& lock, base::Condition& changed, Time_ns until_ns)
        MIDAIR_REQUIRES(mutex);
};

/// Virtual time, which passes only when somebody waits or reads it: as fast as possible and
/// reproducible. For one thread at a time, the simulated host.
class VirtualTime : public EmulatedTime
{
public:
    /// A host that takes time and sometimes stalls.
    struct Host
    {
        Time_ns look_ns = 1'000;  ///< per reading of the clock or datagram
        Time_ns wake_ns = 20'000; ///< extra time per wait
        double pausesPerSecond = 0;
        Time_ns pause_ns = 0; ///< mean; lengths and distances are exponential
        unsigned seed = 1;
    };
    using Call = std::function<void(Time_ns)>;

    /// Calls \a call every \a period_ns > 0, during waits.
    VirtualTime(const Host& host, Time_ns period_ns, Call call);

    Time_ns now_ns() override MIDAIR_EXCLUDES(_mutex);
    void
    wait(base::Mutex& mutex, base::Lock& lock, base::Condition& changed, Time_ns until_ns) override
        MIDAIR_REQUIRES(mutex);

private:
    Time_ns exponential(double mean_ns) MIDAIR_REQUIRES(_mutex);

    const Host _host;
    const Time_ns _period_ns;
    const Call _call;
    Time_ns _nextCall_ns; ///< used by the host's thread
    base::Mutex _mutex;
    std::mt19937 _random MIDAIR_GUARDED_BY(_mutex);
    Time_ns _now_ns MIDAIR_GUARDED_BY(_mutex) = 1'000'000'000;
    Time_ns _nextPause_ns MIDAIR_GUARDED_BY(_mutex) = kNever_ns;
};

/// Units in this program. Any thread may call any member.
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

    /// Calls \a use with the chain, brought up to date, and the time, and wakes threads that wait
    /// for answers.
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

/// A link to units in this program. They have the addresses of real ones.
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

    static autd3::Endpoint addressOf(int id); ///< of a unit; -1: of a foreign sender

private:
    bool send(int to, const std::vector<std::uint8_t>& bytes);

    const std::shared_ptr<EmulatedUnits> _units;
    bool _woken MIDAIR_GUARDED_BY(_units->_mutex) = false;
    bool _refused MIDAIR_GUARDED_BY(_units->_mutex) = false; ///< a send() found no room
};

} // namespace midair::device::emulation
