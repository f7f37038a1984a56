#include "device/autd3/Autd3Device.h"

#include "device/DeviceLog.h"
#include "device/DeviceUri.h"
#include "device/FieldCounters.h"
#include "device/autd3/LinkChoice.h"
#include "device/drive/DriveEncoder.h"
#include "device/drive/DriveSequence.h"
#include "haptics/base/threads/SteadyClock.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

namespace midair::device::autd3
{

namespace
{

// A datagram's time on 100 Mbit/s: Ethernet, IPv6 and UDP add 86 bytes.
constexpr double wire_s(double payloadBytes)
{
    return (payloadBytes + 86) * 80e-9;
}
constexpr double kRaw_s = wire_s(508);
constexpr double kRawTwice_s = wire_s(1006);
constexpr double kSwitch_s = wire_s(16);
constexpr double kAnswers_s = 0.3e-3; // guess: until all have answered
constexpr double kWholeRate = 1e-9;   // relative: off by a period of the rate in days

/// The divider of 40 kHz that makes \a rate_Hz; 0: none does.
int dividerOf(double rate_Hz)
{
    const double exact = DriveSequence::kMostRate_Hz / rate_Hz;
    const double whole = std::round(exact);
    const bool fits =
        whole >= 1 && whole <= kMostDivider && std::abs(exact - whole) <= kWholeRate * whole;
    return fits ? static_cast<int>(whole) : 0;
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
    _refusals(_name)
{
    _report.state = DeviceState::LOST;
    _playing.isLost.resize(static_cast<std::size_t>(options.units));
    try
    {
        connect(false);
    }
    catch (const DeviceError& error)
    {
        if (!wait) throw;
        noteFault(error.what());
        deviceLog().warn("{}; waiting for it", error.what());
    }
    _thread = std::thread([this] { run(); });
}

Autd3Device::~Autd3Device()
{
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        _closing = true;
        if (_link != nullptr) _link->wake();
    }
    _wake.notify_all();
    _thread.join();
}

bool Autd3Device::put(std::shared_ptr<Job> job)
{
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        ++_report.sent;
        if (job == nullptr || _report.state == DeviceState::LOST || _link == nullptr)
        {
            ++_report.refused;
            return false;
        }
        if (_orders.job != nullptr) ++_report.dropped;
        job->sentAt_s = _link->now_s();
        _orders.job = std::move(job);
        _isOrdered = true;
        _link->wake();
    }
    return true;
}

bool Autd3Device::send(const DriveSignal& signal)
{
    if (!signal.fits(_layout.transducers)) return put(nullptr);
    auto job = std::make_shared<Job>();
    job->signals.push_back(signal);
    return put(std::move(job));
}

bool Autd3Device::sendSequence(const DriveSequence& sequence)
{
    const int divider = sequence.fits(_layout.transducers) ? dividerOf(sequence.rate_Hz) : 0;
    if (divider == 0 || sequence.signals.size() > kMostSlots) return put(nullptr);
    auto job = std::make_shared<Job>();
    job->signals = sequence.signals;
    job->divider = divider;
    return put(std::move(job));
}

void Autd3Device::silence()
{
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        if (std::exchange(_orders.job, nullptr) != nullptr) ++_report.dropped;
        _orders.silence = true;
        _orders.silence_s = base::steadySeconds();
        _isOrdered = true;
        _playing.job = nullptr;
        if (_link != nullptr) _link->wake();
    }
}

double Autd3Device::confirmed_s() const
{
    const std::lock_guard<std::mutex> lock(_mutex);
    return _confirmed_s;
}

DeviceReport Autd3Device::report() const
{
    const std::lock_guard<std::mutex> lock(_mutex);
    DeviceReport report = _report;
    report.firmware = _firmware;
    report.pending = report.sent - report.played - report.dropped - report.lost - report.refused;
    return report;
}

std::string Autd3Device::status() const
{
    const DeviceReport now = report();
    if (now.state == DeviceState::LOST)
        return fmt::format("{}: not there; {}", _name, countersText(now));
    std::string text = fmt::format(
        "{}: {} units, firmware {}, {}", _name, _options.units, now.firmware, countersText(now));
    const std::lock_guard<std::mutex> lock(_mutex);
    if (!_refusalText.empty()) text += "; datagrams refused: " + _refusalText;
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
    Playing playing;
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        playing = _playing;
    }
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

Autd3Device::Figures Autd3Device::figures() const
{
    const std::lock_guard<std::mutex> lock(_mutex);
    return _figures;
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
