#include "device/autd3/Autd3Device.h"

#include "device/DeviceLog.h"
#include "device/DeviceUri.h"
#include "device/FieldCounters.h"
#include "device/autd3/UdpLink.h"
#include "device/drive/DriveEncoder.h"
#include "device/drive/DriveSignal.h"
#include "haptics/base/threads/SteadyClock.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <sched.h>
#include <spdlog/spdlog.h>

namespace midair::device::autd3
{

namespace
{

// Duration of a datagram on 100 Mbit/s: Ethernet, IPv6 and UDP add 86 bytes.
constexpr double wire_s(double payloadBytes)
{
    return (payloadBytes + 86) * 80e-9;
}
constexpr double kRaw_s = wire_s(508);
constexpr double kRawTwice_s = wire_s(1006);
constexpr double kSwitch_s = wire_s(16);
constexpr double kAnswers_s = 0.3e-3; // guess: until all have answered
constexpr double kReopen_s = 0.25;
constexpr double kWholeRate = 1e-9; // relative: off by a period of the rate in days

/// Returns the divider of 40 kHz for \a rate_Hz; 0: there is none.
int dividerOf(double rate_Hz)
{
    const double exact = DriveSequence::kMostRate_Hz / rate_Hz;
    const double whole = std::round(exact);
    const bool fits =
        whole >= 1 && whole <= kMostDivider && std::abs(exact - whole) <= kWholeRate * whole;
    return fits ? static_cast<int>(whole) : 0;
}

// A thread that wakes some ms late is too late for the units: it gets priority, if the system
// allows it, and sleeps most of the time. Guards and other children don't inherit it.
void askForPriority()
{
    sched_param priority{};
    priority.sched_priority = 1;
    ::sched_setscheduler(0, SCHED_RR | SCHED_RESET_ON_FORK, &priority); // this thread
}

std::size_t signalOf(const Job& job, double unitTime_ns)
{
    const double slot = std::floor(unitTime_ns / (double(kSlotPeriod_ns) * job.divider));
    return static_cast<std::size_t>(std::fmod(slot, static_cast<double>(job.signals.size())));
}

} // namespace

Autd3Device::Autd3Device(const DeviceLayout& layout,
                         const Autd3Options& options,
                         bool wait,
                         LinkOpener opener) :
    _layout(layout),
    _options(options),
    _opener(opener ? std::move(opener)
                   : [this](const std::function<bool()>& isLeft)
                { return chooseLink(_options, _refusals, isLeft); }),
    _name(deviceName(options)),
    _account(options.units),
    _refusals(_name)
{
    try
    {
        connect(false);
    }
    catch (const DeviceError& error)
    {
        if (!wait) throw;
        _account.noteFault(error.what());
        deviceLog().warn("{}; waiting for it", error.what());
    }
    _thread = std::thread([this] { run(); });
}

Autd3Device::~Autd3Device()
{
    _account.close();
    _thread.join();
}

void Autd3Device::connect(bool isBack)
{
    const std::shared_ptr<DatagramLink> link = _opener([this] { return _account.isClosing(); });
    _account.attach(link);
    _session = std::make_unique<Autd3Session>(link, _options, _name, _refusals, _account, isBack);
}

void Autd3Device::run()
{
    askForPriority();
    std::string refusal;
    for (;;)
    {
        if (_session != nullptr)
        {
            const std::string why = _session->play();
            _session->end(why);
            _session.reset();
            if (why.empty()) return; // closed
            deviceLog().error("{}: {}; silent until it is back", _name, why);
        }
        if (_account.isClosedWithin(kReopen_s)) return;
        try
        {
            connect(true);
            refusal.clear();
            deviceLog().info("{}: back, silent until the next field", _name);
        }
        catch (const DeviceError& error)
        {
            if (refusal != error.what() && !_account.isClosing()) // each reason once
                deviceLog().warn("{}", error.what());
            refusal = error.what();
        }
    }
}

bool Autd3Device::send(const DriveSignal& signal)
{
    if (!signal.fits(_layout.transducers)) return _account.order(nullptr);
    auto job = std::make_shared<Job>();
    job->signals.push_back(signal);
    return _account.order(std::move(job));
}

bool Autd3Device::sendSequence(const DriveSequence& sequence)
{
    const int divider = sequence.fits(_layout.transducers) ? dividerOf(sequence.rate_Hz) : 0;
    if (divider == 0 || sequence.signals.size() > kMostSlots) return _account.order(nullptr);
    auto job = std::make_shared<Job>();
    job->signals = sequence.signals;
    job->divider = divider;
    return _account.order(std::move(job));
}

std::string Autd3Device::status() const
{
    const DeviceReport now = report();
    if (now.state == DeviceState::LOST)
        return fmt::format("{}: not there; {}", _name, countersText(now));
    std::string text = fmt::format(
        "{}: {} units, firmware {}, {}", _name, _options.units, now.firmware, countersText(now));
    const std::string refusals = _account.read([](const auto& told) { return told.refusals; });
    if (!refusals.empty()) text += "; datagrams refused: " + refusals;
    if (!now.complaint.empty()) text += "; " + now.complaint;
    return text;
}

DriveAbility Autd3Device::ability() const
{
    DriveAbility ability;
    const double field_s = _options.timed
                               ? _options.units * (kRawTwice_s + kSwitch_s) + _options.lead_s
                               : _options.units * (kRaw_s + kSwitch_s) + kAnswers_s;
    ability.fieldsPerSecond = 1 / field_s;
    ability.sequenceFields = kMostSlots;
    ability.sequenceClock_Hz = DriveSequence::kMostRate_Hz;
    if (_options.whenLost == WhenLost::ONE_IS_MISSED)
        for (int i = 0; i < _layout.transducers; ++i)
            ability.part.push_back(i / kTransducersPerUnit);
    return ability;
}

std::vector<std::complex<float>> Autd3Device::played() const
{
    const auto playing = _account.read([](const auto& told) { return told.playing; });
    if (playing.job == nullptr)
        return std::vector<std::complex<float>>(static_cast<std::size_t>(_layout.transducers));
    std::vector<std::complex<float>> q;
    const double time_ns = base::steadySeconds() * 1e9 + playing.offset_ns;
    decode(playing.job->signals[signalOf(*playing.job, std::max(0.0, time_ns))], q);
    for (std::size_t unit = 0; unit < playing.isLost.size(); ++unit)
        if (playing.isLost[unit])
            std::fill_n(q.begin() + _options.order[unit] * kTransducersPerUnit,
                        kTransducersPerUnit,
                        std::complex<float>());
    return q;
}

} // namespace midair::device::autd3

namespace midair::device
{

std::unique_ptr<ArrayDevice> openAutd3(DeviceUri& uri, const DeviceLayout& layout)
{
    const autd3::Autd3Options options = autd3::takeAutd3Options(uri, layout);
    const bool wait = uri.takeFlag("wait", false);
    uri.rejectUnknown();
    return std::make_unique<autd3::Autd3Device>(layout, options, wait);
}

} // namespace midair::device
