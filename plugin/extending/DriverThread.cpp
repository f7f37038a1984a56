#include "plugin/extending/DriverThread.h"

#include "device/DeviceLog.h"
#include "device/FieldQueue.h"
#include "device/SequenceNumber.h"
#include "device/drive/DriveEncoder.h"
#include "haptics/base/threads/SteadyClock.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace osgMidair
{

using midair::device::DeviceReport;
using midair::device::DeviceState;
using midair::device::DriveSignal;

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

/// Returns what \a call has thrown, in words; empty: nothing.
template<typename Call>
std::string faultOf(const Call& call)
{
    try
    {
        call();
        return {};
    }
    catch (const std::exception& error)
    {
        return std::string("the driver threw: ") + error.what();
    }
    catch (...)
    {
        return "the driver threw what is no std::exception";
    }
}

} // namespace

/// What the thread and its owner share.
struct DriverThread::Shared
{
    Shared(Opened&& opened, std::string itsName, DriverLevels&& itsLevels, int count);

    void run();
    void silenceLocked();
    DeviceReport reportLocked() const;

    const std::string name;
    const DriverLevels levels;
    const int transducers;
    std::mutex mutex; ///< guards what follows; never held while the driver is called
    std::condition_variable wake;
    midair::device::FieldQueue fields;
    DriveSignal playing;
    DeviceReport own; ///< all but the counters of fields
    std::string status;
    bool closing = false;
    bool ended = false;
    bool isLeft = false; ///< nobody waits for the thread any more

private:
    template<typename Call, typename Result>
    Result
    ask(std::unique_lock<std::mutex>& lock, const char* what, const Call& call, Result otherwise);
    void look(std::unique_lock<std::mutex>& lock);
    void askIfReady(std::unique_lock<std::mutex>& lock);
    void playNext(std::unique_lock<std::mutex>& lock);

    std::uint32_t _sequence = 0;
    std::uint64_t _epoch = 0; ///< counts silences; a field of an older one is not what plays
    bool _silenceWanted = false;
    const char* _call = nullptr; ///< what the driver is called for now
    double _callSince_s = 0.0;
    // The thread's alone.
    osg::ref_ptr<DeviceDriver> _driver;
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
    playing(midair::device::silentSignal(count)),
    status(std::move(opened.status)),
    _driver(std::move(opened.driver)),
    _lookAt_s(midair::base::steadySeconds() + kLook_s)
{
    if (opened.isReady) return;
    own.state = DeviceState::LOST;
    own.message = kNotReady;
}

// Returns what the driver returns, or otherwise if it throws.
template<typename Call, typename Result>
Result DriverThread::Shared::ask(std::unique_lock<std::mutex>& lock,
                                 const char* what,
                                 const Call& call,
                                 Result otherwise)
{
    _call = what;
    _callSince_s = midair::base::steadySeconds();
    lock.unlock();
    const std::string fault = faultOf([&] { otherwise = call(); });
    lock.lock();
    _call = nullptr;
    if (fault.empty()) return otherwise;
    ++own.faults;
    own.message = fault;
    return otherwise;
}

// One loss is one fault, however many fields it costs.
void DriverThread::Shared::askIfReady(std::unique_lock<std::mutex>& lock)
{
    const std::uint64_t faults = own.faults;
    const bool isReady = ask(
        lock, "isReady()", [this] { return _driver->isReady(); }, false);
    const bool wasReady = own.state == DeviceState::READY;
    if (isReady == wasReady) return;
    own.state = isReady ? DeviceState::READY : DeviceState::LOST;
    if (isReady)
        ++own.reconnects;
    else if (own.faults == faults)
    {
        ++own.faults;
        own.message = kNotReady;
    }
}

void DriverThread::Shared::look(std::unique_lock<std::mutex>& lock)
{
    askIfReady(lock);
    status = ask(
        lock, "getStatus()", [this] { return _driver->getStatus(); }, std::string());
    _lookAt_s = midair::base::steadySeconds() + kLook_s;
}

void DriverThread::Shared::playNext(std::unique_lock<std::mutex>& lock)
{
    askIfReady(lock);
    if (_silenceWanted || !fields.waits()) return; // a silence came meanwhile
    const auto& field = fields.takeOff(_sequence = midair::device::nextAfter(_sequence));
    if (own.state != DeviceState::READY) return fields.loseOldest();
    levels.round(field.signal, _phases, _amplitudes);
    const double sentAt_s = field.sentAt_s;
    const std::uint64_t epoch = _epoch;
    const std::uint64_t faults = own.faults;
    const bool taken = ask(
        lock,
        "play()",
        [this] { return _driver->play(_phases.data(), _amplitudes.data()); },
        false);
    if (!taken)
    {
        fields.loseOldest();
        if (own.faults == faults) own.message = "the driver took no field";
        return;
    }
    auto played = fields.settleUntil(_sequence, _sequence);
    if (played && epoch == _epoch) playing = std::move(*played);
    own.lastHandedOver_s = midair::base::steadySeconds();
    own.latency_s = own.lastHandedOver_s - sentAt_s;
}

void DriverThread::Shared::silenceLocked()
{
    fields.dropWaiting();
    playing = midair::device::silentSignal(transducers);
    ++_epoch;
    _silenceWanted = true;
    wake.notify_all();
}

DeviceReport DriverThread::Shared::reportLocked() const
{
    DeviceReport report = own;
    fields.addTo(report);
    const double since_s = _call ? midair::base::steadySeconds() - _callSince_s : 0.0;
    if (since_s <= kHangs_s) return report;
    report.state = std::max(report.state, DeviceState::HANGING);
    report.message = fmt::format("the driver's {} hasn't returned for {:.0f} s", _call, since_s);
    return report;
}

void DriverThread::Shared::run()
{
    std::unique_lock<std::mutex> lock(mutex);
    for (;;)
    {
        const double rest_s = _lookAt_s - midair::base::steadySeconds();
        if (std::exchange(_silenceWanted, false))
            ask(
                lock, "silence()", [this] { return _driver->silence(), true; }, true);
        else if (closing)
            break;
        else if (rest_s <= 0.0)
            look(lock);
        else if (fields.waits())
            playNext(lock);
        else
            wake.wait_for(lock, std::chrono::duration<double>(rest_s));
    }
    lock.unlock();
    faultOf([this] { _driver = nullptr; });
    lock.lock();
    ended = true;
    wake.notify_all();
    if (!isLeft) return;
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
        shared.silenceLocked();
        shared.closing = true;
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
        return;
    }
    _thread.detach();
    midair::device::logDeviceError(
        fmt::format("{}: its driver hasn't returned for {:g} s, so it is closed without; the array "
                    "may still play what it had until the driver returns",
                    shared.name,
                    kFarewell_s));
}

bool DriverThread::send(const DriveSignal& signal)
{
    const std::lock_guard<std::mutex> lock(_shared->mutex);
    if (!signal.fits(_shared->transducers) || _shared->own.state != DeviceState::READY)
    {
        _shared->fields.refuse();
        return false;
    }
    _shared->fields.put(signal, midair::base::steadySeconds(), nullptr);
    _shared->wake.notify_all();
    return true;
}

void DriverThread::silence()
{
    const std::lock_guard<std::mutex> lock(_shared->mutex);
    _shared->silenceLocked();
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

} // namespace osgMidair
