#include "engine-bridge/extending/DriverThread.h"

#include "device/DeviceLog.h"
#include "device/FieldQueue.h"
#include "device/SequenceNumber.h"
#include "device/drive/DriveEncoder.h"
#include "engine-bridge/extending/DueSilence.h"
#include "haptics/base/ThrownBy.h"
#include "haptics/base/threads/SteadyClock.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace midair::bridge
{

using device::DeviceReport;
using device::DeviceState;
using device::DriveSignal;

namespace
{

constexpr double kLook_s = 0.2; // interval of asking a driver that plays nothing new how it is

constexpr const char* kNotReady = "the driver is not ready";

/// The devices whose drivers hang though they have been closed. Never destroyed, as their threads
/// may outlive the program's static objects.
struct LeftBehind
{
    std::mutex mutex;
    std::vector<std::string> names;

    static LeftBehind& all()
    {
        static auto* const left = new LeftBehind;
        return *left;
    }
};

} // namespace

/// What the thread and its owner share.
struct DriverThread::Shared
{
    Shared(Opened&& opened, std::string itsName, DriverLevels&& itsLevels, int count);

    void run();
    void silenceLocked();
    void closeLocked();
    DeviceReport reportLocked() const;

    const std::string name;
    const DriverLevels levels;
    const int transducers;
    std::mutex mutex; ///< guards what follows; never held while the driver is called
    std::condition_variable wake;
    device::FieldQueue fields;
    double silenced_s =
        0.0; ///< when the last silence was asked for that the driver has carried out
    DriveSignal playing;
    DeviceReport own; ///< all but the counters of fields
    std::string status;
    bool closing = false;
    bool ended = false;
    bool isLeft = false;   ///< nobody waits for the thread any more
    std::string lastWords; ///< what the log has to say of it once it has ended

private:
    template<typename Call>
    std::string ask(std::unique_lock<std::mutex>& lock, const char* what, const Call& call);
    void callSilence(std::unique_lock<std::mutex>& lock);
    void look(std::unique_lock<std::mutex>& lock);
    void askIfReady(std::unique_lock<std::mutex>& lock);
    void playNext(std::unique_lock<std::mutex>& lock);
    void end(std::unique_lock<std::mutex>& lock);

    std::uint32_t _sequence = 0;
    std::uint64_t _epoch = 0; ///< counts silences; a field of an older one is not what plays
    double _silenceAsked_s = 0.0;
    DueSilence _silence;
    const char* _call = nullptr; ///< what the driver is called for now
    double _callSince_s = 0.0;
    // The thread's alone.
    std::shared_ptr<ArrayDriver> _driver;
    std::vector<unsigned char> _phases;
    std::vector<unsigned char> _amplitudes;
    double _lookAt_s = 0.0;
};

DriverThread::Shared::Shared(Opened&& opened,
                             std::string itsName,
                             DriverLevels&& itsLevels,
                             int count) :
    name(std::move(itsName)),
    levels(std::move(itsLevels)),
    transducers(count),
    playing(device::silentSignal(count)),
    status(std::move(opened.status)),
    _driver(opened.driver),
    _lookAt_s(base::steadySeconds() + kLook_s)
{
    if (opened.isReady) return;
    own.state = DeviceState::LOST;
    own.message = kNotReady;
    _silence.wantNow();
}

// Returns what the driver has thrown, in words; empty: nothing.
template<typename Call>
std::string
DriverThread::Shared::ask(std::unique_lock<std::mutex>& lock, const char* what, const Call& call)
{
    _call = what;
    _callSince_s = base::steadySeconds();
    lock.unlock();
    const std::string thrown = base::thrownBy(call);
    lock.lock();
    _call = nullptr;
    return thrown.empty() ? thrown : fmt::format("the driver's {} has thrown {}", what, thrown);
}

// Nobody knows what sounds until it has returned, so nothing else is played before. However often
// it fails in a row is one fault.
void DriverThread::Shared::callSilence(std::unique_lock<std::mutex>& lock)
{
    _silence.begin();
    const double asked_s = _silenceAsked_s;
    const std::string fault = ask(lock, "silence()", [this] { _driver->silence(); });
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

// One loss is one fault, however many fields it costs. What plays when the device is back is not
// known, so it is silenced before it plays the first field.
void DriverThread::Shared::askIfReady(std::unique_lock<std::mutex>& lock)
{
    bool isReady = false;
    const std::string fault = ask(lock, "isReady()", [&] { isReady = _driver->isReady(); });
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

void DriverThread::Shared::look(std::unique_lock<std::mutex>& lock)
{
    askIfReady(lock);
    if (own.state == DeviceState::READY)
    {
        std::string text;
        const std::string fault = ask(lock, "getStatus()", [&] { text = _driver->getStatus(); });
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

void DriverThread::Shared::playNext(std::unique_lock<std::mutex>& lock)
{
    askIfReady(lock);
    if (_silence.isWanted() || !fields.waits()) return; // one came meanwhile, or the device is lost
    const auto& field = fields.takeOff(_sequence = device::nextAfter(_sequence));
    levels.round(field.signal, _phases, _amplitudes);
    const double sentAt_s = field.sentAt_s;
    const std::uint64_t epoch = _epoch;
    bool taken = false;
    const std::string fault =
        ask(lock, "play()", [&] { taken = _driver->play(_phases.data(), _amplitudes.data()); });
    if (!taken)
    {
        fields.loseOldest();
        if (!fault.empty()) ++own.faults;
        own.message = fault.empty() ? "the driver took no field" : fault;
        return;
    }
    auto played = fields.settleUntil(_sequence, _sequence);
    if (played && epoch == _epoch) playing = std::move(*played);
    own.lastHandedOver_s = base::steadySeconds();
    own.latency_s = own.lastHandedOver_s - sentAt_s;
}

void DriverThread::Shared::silenceLocked()
{
    fields.dropWaiting();
    playing = device::silentSignal(transducers);
    ++_epoch;
    _silenceAsked_s = base::steadySeconds();
    _silence.want();
    wake.notify_all();
}

void DriverThread::Shared::closeLocked()
{
    silenceLocked();
    _silence.wantNow();
    closing = true;
}

DeviceReport DriverThread::Shared::reportLocked() const
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
    report.message = fmt::format("the driver's {} hasn't returned for {:.0f} s", _call, since_s);
    return report;
}

void DriverThread::Shared::run()
{
    std::unique_lock<std::mutex> lock(mutex);
    while (!closing || (_silence.isWanted() && !_silence.isGivenUp()))
    {
        const double now_s = base::steadySeconds();
        const double rest_s =
            std::min(_silence.rest_s(now_s), closing ? DueSilence::kSoon_s : _lookAt_s - now_s);
        if (_silence.isDue(now_s))
            callSilence(lock);
        else if (!closing && _lookAt_s <= now_s)
            look(lock);
        else if (!closing && fields.waits() && !_silence.isWanted())
            playNext(lock);
        else
            wake.wait_for(lock, std::chrono::duration<double>(rest_s));
    }
    end(lock);
}

void DriverThread::Shared::end(std::unique_lock<std::mutex>& lock)
{
    if (!own.unsilenced.empty())
        lastWords = fmt::format("{}: {}; it is closed all the same", name, own.unsilenced);
    lock.unlock();
    base::thrownBy([this] { _driver = nullptr; });
    lock.lock();
    ended = true;
    wake.notify_all();
    if (!isLeft) return;
    lock.unlock();
    if (!lastWords.empty()) device::logDeviceError(lastWords);
    LeftBehind& left = LeftBehind::all();
    const std::lock_guard<std::mutex> all(left.mutex);
    left.names.erase(std::find(left.names.begin(), left.names.end(), name));
}

DriverThread::DriverThread(Opened opened,
                           const std::string& name,
                           DriverLevels levels,
                           int transducers) :
    _shared(std::make_shared<Shared>(std::move(opened), name, std::move(levels), transducers)),
    _thread([shared = _shared] { shared->run(); })
{
}

DriverThread::~DriverThread()
{
    Shared& shared = *_shared;
    {
        std::unique_lock<std::mutex> lock(shared.mutex);
        shared.closeLocked();
        shared.wake.wait_for(
            lock, std::chrono::duration<double>(kFarewell_s), [&] { return shared.ended; });
        shared.isLeft = !shared.ended;
        if (shared.isLeft)
        {
            LeftBehind& left = LeftBehind::all();
            const std::lock_guard<std::mutex> all(left.mutex);
            left.names.push_back(shared.name);
        }
    }
    if (!shared.isLeft)
    {
        _thread.join();
        if (!shared.lastWords.empty()) device::logDeviceError(shared.lastWords);
        return;
    }
    _thread.detach();
    device::logDeviceError(
        fmt::format("{}: its driver hasn't returned for {:g} s, so it is closed without; the array "
                    "may still play what it had until the driver returns",
                    shared.name,
                    kFarewell_s));
}

bool DriverThread::send(const DriveSignal& signal)
{
    const std::lock_guard<std::mutex> lock(_shared->mutex);
    const DeviceReport& own = _shared->own;
    const bool isReady = own.state == DeviceState::READY && own.unsilenced.empty();
    if (!signal.fits(_shared->transducers) || !isReady)
    {
        _shared->fields.refuse();
        return false;
    }
    _shared->fields.put(signal, base::steadySeconds(), nullptr);
    _shared->wake.notify_all();
    return true;
}

void DriverThread::silence()
{
    const std::lock_guard<std::mutex> lock(_shared->mutex);
    _shared->silenceLocked();
}

double DriverThread::confirmed_s() const
{
    const std::lock_guard<std::mutex> lock(_shared->mutex);
    return std::max(_shared->fields.confirmed_s(), _shared->silenced_s);
}

DeviceReport DriverThread::report() const
{
    const std::lock_guard<std::mutex> lock(_shared->mutex);
    return _shared->reportLocked();
}

std::string DriverThread::status() const
{
    const std::lock_guard<std::mutex> lock(_shared->mutex);
    return _shared->status;
}

DriveSignal DriverThread::playing() const
{
    const std::lock_guard<std::mutex> lock(_shared->mutex);
    return _shared->playing;
}

bool DriverThread::isLeftBehind(const std::string& name)
{
    LeftBehind& left = LeftBehind::all();
    const std::lock_guard<std::mutex> all(left.mutex);
    return std::find(left.names.begin(), left.names.end(), name) != left.names.end();
}

} // namespace midair::bridge
