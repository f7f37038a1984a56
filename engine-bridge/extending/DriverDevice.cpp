#include "engine-bridge/extending/DriverDevice.h"

#include "device/DeviceLog.h"
#include "device/FieldCounters.h"
#include "device/FieldQueue.h"
#include "device/SequenceNumber.h"
#include "device/drive/DriveEncoder.h"
#include "haptics/base/DutyLaw.h"
#include "haptics/base/ThrownBy.h"
#include "haptics/base/Units.h"
#include "haptics/base/threads/Mutex.h"
#include "haptics/base/threads/SteadyClock.h"

#include <cmath>
#include <utility>

#include <fmt/format.h>

namespace midair::bridge
{

using device::DeviceReport;
using device::DeviceState;
using device::DriveSignal;

namespace
{

constexpr double kLook_s = 0.2; // interval of status queries of an idle driver

constexpr const char* kNotReady = "the driver is not ready";

/// Closed devices whose drivers hang. Never destroyed, because their threads may outlive the
/// program's static objects.
struct LeftBehind
{
    base::Mutex mutex;
    std::vector<std::string> names MIDAIR_GUARDED_BY(mutex);

    static LeftBehind& all()
    {
        static auto* const left = new LeftBehind;
        return *left;
    }
};

void checkLevels(const std::string& name, unsigned int phases, const std::vector<float>& amplitudes)
{
    const auto refuse = [&](const std::string& what)
    { throw device::DeviceError("device \"" + name + "\": " + what); };
    if (phases < 2 || phases > 256)
        refuse(fmt::format("its driver has {} phase levels; there must be 2 .. 256", phases));
    if (amplitudes.empty()) return;
    const bool rises =
        std::adjacent_find(amplitudes.begin(),
                           amplitudes.end(),
                           [](float a, float b) { return !(a < b); }) == amplitudes.end();
    if (amplitudes.size() < 2 || amplitudes.size() > 256 || !rises || amplitudes.front() != 0.0F ||
        amplitudes.back() != 1.0F)
        refuse("its driver's amplitudes must be 2 .. 256 that rise from 0 to 1");
}

} // namespace

DriverLevels::DriverLevels(const std::string& name,
                           unsigned int phaseLevels,
                           std::vector<float> amplitudes) :
    _phaseLevels(phaseLevels),
    _amplitudes(std::move(amplitudes))
{
    checkLevels(name, _phaseLevels, _amplitudes);
    for (const float amplitude : _amplitudes)
        _duties.push_back(
            static_cast<int>(std::lround(base::dutyLevel(static_cast<double>(amplitude)))));
}

unsigned char DriverLevels::phaseOf(std::uint8_t level) const
{
    return static_cast<unsigned char>((level * _phaseLevels + 128U) / 256U % _phaseLevels);
}

// Each level of the driver is encoded as its own duty.
unsigned char DriverLevels::amplitudeOf(std::uint8_t duty) const
{
    if (_duties.empty()) return duty;
    const auto above = std::upper_bound(_duties.begin(), _duties.end(), static_cast<int>(duty));
    return static_cast<unsigned char>(above - _duties.begin() - 1);
}

void DriverLevels::round(const device::DriveSignal& signal,
                         std::vector<unsigned char>& phases,
                         std::vector<unsigned char>& amplitudes) const
{
    phases.resize(signal.phase.size());
    amplitudes.resize(signal.phase.size());
    for (std::size_t i = 0; i < phases.size(); ++i)
    {
        phases[i] = phaseOf(signal.phase[i]);
        amplitudes[i] = amplitudeOf(signal.duty[i]);
    }
}

std::vector<std::complex<float>> DriverLevels::activations(const device::DriveSignal& signal) const
{
    std::vector<std::complex<float>> q(signal.phase.size());
    for (std::size_t i = 0; i < q.size(); ++i)
    {
        const unsigned char level = amplitudeOf(signal.duty[i]);
        const float amplitude =
            _amplitudes.empty() ? device::amplitudeLevels()[level] : _amplitudes[level];
        q[i] = std::polar(
            amplitude, static_cast<float>(base::kTwoPi * phaseOf(signal.phase[i]) / _phaseLevels));
    }
    return q;
}

/// State shared by the thread and its owner.
struct DriverDevice::Shared
{
    Shared(Opened&& opened, const std::string& itsName, int count) :
        name(itsName),
        levels(itsName, opened.phaseLevels, std::move(opened.amplitudes)),
        transducers(count),
        playing(device::silentSignal(count)),
        status(std::move(opened.status)),
        _driver(std::move(opened.driver)),
        _lookAt_s(base::steadySeconds() + kLook_s)
    {
        if (opened.isReady) return;
        own.state = DeviceState::LOST;
        own.message = kNotReady;
        _silence.wantNow();
    }

    void run()
    {
        base::Lock lock(mutex);
        while (!closing || (_silence.isWanted() && !_silence.isGivenUp()))
        {
            const double now_s = base::steadySeconds();
            const double rest_s =
                std::min(_silence.rest_s(now_s), closing ? DueSilence::kSoon_s : _lookAt_s - now_s);
            if (_silence.isDue(now_s))
                callSilence();
            else if (!closing && _lookAt_s <= now_s)
                look();
            else if (!closing && fields.waits() && !_silence.isWanted())
                playNext();
            else
                wake.waitFor(lock, std::chrono::duration<double>(rest_s));
        }
        end();
    }
    void silenceLocked() MIDAIR_REQUIRES(mutex)
    {
        fields.dropWaiting();
        playing = device::silentSignal(transducers);
        ++_epoch;
        _silenceAsked_s = base::steadySeconds();
        _silence.want();
        wake.notifyAll();
    }
    void closeLocked() MIDAIR_REQUIRES(mutex)
    {
        silenceLocked();
        _silence.wantNow();
        closing = true;
    }
    DeviceReport reportLocked() const MIDAIR_REQUIRES(mutex)
    {
        DeviceReport report = own;
        fields.addTo(report);
        if (!report.unsilenced.empty() && report.state != DeviceState::LOST)
        {
            report.state = DeviceState::HANGING;
            report.message = report.unsilenced;
        }
        const double since_s = _call ? base::steadySeconds() - _callSince_s : 0.0;
        if (since_s <= kHangs_s) return report;
        report.state = std::max(report.state, DeviceState::HANGING);
        report.message =
            fmt::format("the driver's {} hasn't returned for {:.0f} s", _call, since_s);
        return report;
    }

    const std::string name;
    const DriverLevels levels;
    const int transducers;
    mutable base::Mutex mutex; ///< never held while the driver is called
    base::Condition wake;
    device::FieldQueue fields MIDAIR_GUARDED_BY(mutex);
    /// request time of the last silence that the driver has carried out
    double silenced_s MIDAIR_GUARDED_BY(mutex) = 0.0;
    DriveSignal playing MIDAIR_GUARDED_BY(mutex);
    DeviceReport own MIDAIR_GUARDED_BY(mutex); ///< all except the field counters
    std::string status MIDAIR_GUARDED_BY(mutex);
    bool closing MIDAIR_GUARDED_BY(mutex) = false;
    bool ended MIDAIR_GUARDED_BY(mutex) = false;
    bool isLeft MIDAIR_GUARDED_BY(mutex) = false; ///< the owner no longer waits for the thread
    /// log message for when it has ended
    std::string lastWords MIDAIR_GUARDED_BY(mutex);

private:
    // Returns the driver's exception as text; empty: none.
    template<typename Call>
    std::string ask(const char* what, const Call& call) MIDAIR_REQUIRES(mutex)
    {
        _call = what;
        _callSince_s = base::steadySeconds();
        std::string thrown;
        {
            const base::Unlocked open(mutex);
            thrown = base::thrownBy(call);
        }
        _call = nullptr;
        return thrown.empty() ? thrown : fmt::format("the driver's {} has thrown {}", what, thrown);
    }
    // Until it returns, the output is unknown, so nothing else is played before. Consecutive
    // failures count as one fault.
    void callSilence() MIDAIR_REQUIRES(mutex)
    {
        _silence.begin();
        const double asked_s = _silenceAsked_s;
        const std::string fault = ask("silence()", [this] { _driver->silence(); });
        const bool isSeldom = own.state == DeviceState::LOST && !closing;
        if (fault.empty())
        {
            _silence.succeed(base::steadySeconds(), isSeldom);
            own.unsilenced.clear();
            silenced_s = asked_s;
            return;
        }
        _silence.fail(base::steadySeconds(), isSeldom);
        if (own.unsilenced.empty()) ++own.faults;
        own.unsilenced =
            fmt::format("the driver couldn't silence the array ({}); it may play on", fault);
    }
    void look() MIDAIR_REQUIRES(mutex)
    {
        askIfReady();
        if (own.state == DeviceState::READY)
        {
            std::string text;
            const std::string fault = ask("getStatus()", [&] { text = _driver->getStatus(); });
            status = std::move(text);
            if (!fault.empty() && own.complaint.empty())
            {
                ++own.faults;
                own.message = fault;
            }
            own.complaint = fault;
        }
        _lookAt_s = base::steadySeconds() + kLook_s;
    }
    // A loss is one fault, whatever the number of lost fields. The output of a device that comes
    // back is unknown, so it is silenced before it plays the first field.
    void askIfReady() MIDAIR_REQUIRES(mutex)
    {
        bool isReady = false;
        const std::string fault = ask("isReady()", [&] { isReady = _driver->isReady(); });
        if (!fault.empty()) isReady = false;
        const bool wasReady = own.state == DeviceState::READY;
        if (isReady == wasReady) return;
        own.state = isReady ? DeviceState::READY : DeviceState::LOST;
        _silence.wantNow();
        if (isReady)
        {
            ++own.reconnects;
            return;
        }
        ++own.faults;
        own.message = fault.empty() ? kNotReady : fault;
        status.clear();
        if (!fields.waits()) return;
        fields.takeOff(_sequence = device::nextAfter(_sequence));
        fields.loseOldest();
    }
    void playNext() MIDAIR_REQUIRES(mutex)
    {
        askIfReady();
        if (_silence.isWanted() || !fields.waits())
            return; // a new silence came meanwhile, or the device is lost
        const auto& field = fields.takeOff(_sequence = device::nextAfter(_sequence));
        levels.round(field.signal, _phases, _amplitudes);
        const double sentAt_s = field.sentAt_s;
        const std::uint64_t epoch = _epoch;
        bool taken = false;
        const std::string fault =
            ask("play()", [&] { taken = _driver->play(_phases.data(), _amplitudes.data()); });
        if (!taken)
        {
            fields.loseOldest();
            if (!fault.empty()) ++own.faults;
            own.message = fault.empty() ? "the driver didn't accept the field" : fault;
            return;
        }
        auto played = fields.settleUntil(_sequence, _sequence);
        if (played && epoch == _epoch) playing = std::move(*played);
        own.lastHandedOver_s = base::steadySeconds();
        own.latency_s = own.lastHandedOver_s - sentAt_s;
    }
    void end() MIDAIR_REQUIRES(mutex)
    {
        if (!own.unsilenced.empty())
            lastWords = fmt::format("{}: {}; it is closed anyway", name, own.unsilenced);
        {
            const base::Unlocked open(mutex);
            base::thrownBy([this] { _driver = nullptr; });
        }
        ended = true;
        wake.notifyAll();
        if (!isLeft) return;
        const std::string words = lastWords;
        const base::Unlocked open(mutex);
        if (!words.empty()) device::logDeviceError(words);
        LeftBehind& left = LeftBehind::all();
        const base::Lock all(left.mutex);
        left.names.erase(std::find(left.names.begin(), left.names.end(), name));
    }

    std::uint32_t _sequence MIDAIR_GUARDED_BY(mutex) = 0;
    /// counts silences; fields of older epochs are not playing
    std::uint64_t _epoch MIDAIR_GUARDED_BY(mutex) = 0;
    double _silenceAsked_s MIDAIR_GUARDED_BY(mutex) = 0.0;
    DueSilence _silence MIDAIR_GUARDED_BY(mutex);
    const char* _call MIDAIR_GUARDED_BY(mutex) = nullptr; ///< name of the running call
    double _callSince_s MIDAIR_GUARDED_BY(mutex) = 0.0;
    // Used by the thread only.
    std::shared_ptr<ArrayDriver> _driver;
    std::vector<unsigned char> _phases;
    std::vector<unsigned char> _amplitudes;
    double _lookAt_s = 0.0;
};

DriverDevice::Opened DriverDevice::ask(const std::shared_ptr<ArrayDriver>& driver)
{
    return {driver,
            driver->isReady(),
            driver->getStatus(),
            driver->getPhaseLevels(),
            driver->getAmplitudes(),
            driver->getFieldsPerSecond()};
}

DriverDevice::DriverDevice(Opened opened, const std::string& name, int transducers) :
    _fieldsPerSecond(std::max(0.0, opened.fieldsPerSecond)),
    _shared(std::make_shared<Shared>(std::move(opened), name, transducers)),
    _thread([shared = _shared] { shared->run(); })
{
}

DriverDevice::~DriverDevice()
{
    Shared& shared = *_shared;
    bool isLeft = false;
    {
        base::Lock lock(shared.mutex);
        shared.closeLocked();
        const double until_s = base::steadySeconds() + kFarewell_s;
        while (!shared.ended && shared.wake.waitUntil_s(lock, until_s))
        {
        }
        isLeft = shared.isLeft = !shared.ended;
        if (isLeft)
        {
            LeftBehind& left = LeftBehind::all();
            const base::Lock all(left.mutex);
            left.names.push_back(shared.name);
        }
    }
    if (!isLeft)
    {
        _thread.join();
        const base::Lock lock(shared.mutex);
        if (!shared.lastWords.empty()) device::logDeviceError(shared.lastWords);
        return;
    }
    _thread.detach();
    device::logDeviceError(
        fmt::format("{}: its driver hasn't returned for {:g} s, so it is closed without waiting; "
                    "the array may play its last field until the driver returns",
                    shared.name,
                    kFarewell_s));
}

bool DriverDevice::send(const DriveSignal& signal)
{
    Shared& shared = *_shared;
    const base::Lock lock(shared.mutex);
    const bool isReady = shared.own.state == DeviceState::READY && shared.own.unsilenced.empty();
    if (!signal.fits(shared.transducers) || !isReady)
    {
        shared.fields.refuse();
        return false;
    }
    shared.fields.put(signal, base::steadySeconds(), nullptr);
    shared.wake.notifyAll();
    return true;
}

void DriverDevice::silence()
{
    const base::Lock lock(_shared->mutex);
    _shared->silenceLocked();
}

double DriverDevice::confirmed_s() const
{
    const base::Lock lock(_shared->mutex);
    return std::max(_shared->fields.confirmed_s(), _shared->silenced_s);
}

DeviceReport DriverDevice::report() const
{
    const base::Lock lock(_shared->mutex);
    return _shared->reportLocked();
}

// The driver's status from before a loss is outdated.
std::string DriverDevice::status() const
{
    const base::Lock lock(_shared->mutex);
    const DeviceReport report = _shared->reportLocked();
    const bool isLost = report.state == DeviceState::LOST;
    const std::string own = isLost                                ? "lost"
                            : report.state < DeviceState::HANGING ? _shared->status
                            : report.unsilenced.empty()           ? "hangs"
                                                                  : "not silenced";
    const std::string& name = _shared->name;
    return name + (name.back() == ':' ? " " : ": ") + (own.empty() ? "" : own + ": ") +
           device::countersText(report) +
           (isLost && !report.unsilenced.empty() ? "; " + report.unsilenced : "");
}

device::DriveAbility DriverDevice::ability() const
{
    device::DriveAbility ability;
    ability.phaseLevels = static_cast<int>(_shared->levels.phaseLevels());
    ability.amplitudes = _shared->levels.amplitudes();
    ability.fieldsPerSecond = _fieldsPerSecond;
    return ability;
}

std::vector<std::complex<float>> DriverDevice::played() const
{
    const base::Lock lock(_shared->mutex);
    return _shared->levels.activations(_shared->playing);
}

std::vector<std::complex<float>> DriverDevice::wouldPlay(const DriveSignal& signal) const
{
    return _shared->levels.activations(signal);
}

bool DriverDevice::isLeftBehind(const std::string& name)
{
    LeftBehind& left = LeftBehind::all();
    const base::Lock all(left.mutex);
    return std::find(left.names.begin(), left.names.end(), name) != left.names.end();
}

} // namespace midair::bridge
