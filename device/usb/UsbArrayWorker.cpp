#include "device/DeviceUri.h"
#include "device/DriveEncoder.h"
#include "device/usb/UsbArrayDevice.h"
#include "haptics/base/text/Number.h"

#include <algorithm>

#include <spdlog/spdlog.h>

namespace midair::device
{

using Outcome = UsbTransferPool::Outcome;
using protocol::Packet;
using protocol::Type;
namespace
{

constexpr double kReconnect_s = 0.25;
constexpr double kStatusInterval_s = 0.25;
constexpr double kSilentDevice_s = 1.0; // without a valid answer it is given up and opened anew
constexpr double kMuteRetry_s = 0.02;
constexpr double kConfirm_s = 0.5;
constexpr int kMostFaultsInRow = 5;
constexpr int kMostAsked = 3;

std::chrono::duration<double> seconds(double s)
{
    return std::chrono::duration<double>(s);
}

} // namespace

// With _mutex held: what was on its way is lost, or dropped when the device merely was told to be silent.
std::vector<UsbArrayDevice::Joint> UsbArrayDevice::settleAll(bool lost)
{
    const std::uint64_t waiting = _slotFull ? 1 : 0;
    const std::uint64_t flying = _flying.size();
    std::vector<Joint> joints;
    if (_slotFull && _slot.joint != nullptr) joints.push_back(std::move(_slot.joint));
    if (isStaged()) joints.push_back(std::move(_flying.back().joint));
    _slotFull = false;
    _flying.clear();
    std::fill(_playing.duty.begin(), _playing.duty.end(), std::uint8_t(0));
    _counters.change(
        [&](DeviceReport& report)
        {
            report.dropped += waiting + (lost ? 0 : flying);
            report.lost += lost ? flying : 0;
        });
    return joints;
}

void UsbArrayDevice::disconnect(const std::string& why)
{
    std::unique_ptr<UsbTransferPool> pool;
    std::vector<Joint> joints;
    {
        std::unique_lock<std::mutex> lock(_mutex);
        _free.wait(lock, [&] { return !_busy; });
        pool = std::move(_pool);
        _ready = false;
        joints = settleAll(true);
        _muteAwaited = 0;
    }
    _heard.notify_all();
    for (const Joint& joint : joints)
        joint->leave(_seat.get());
    note(why);
    _counters.change([](DeviceReport& report) { report.state = DeviceState::LOST; });
    spdlog::error("{}: {}; silent until it is back", _name, why);
    // The pool's destructor waits for callbacks that need _mutex, so it ends here, outside the lock.
}

void UsbArrayDevice::run()
{
    std::string refusal;
    std::unique_lock<std::mutex> lock(_mutex);
    while (!_closing)
    {
        if (_pool == nullptr)
        {
            _wake.wait_for(lock, seconds(kReconnect_s), [&] { return _closing; });
            if (_closing) break;
            lock.unlock();
            try
            {
                connect();
                refusal.clear();
                _counters.change([](DeviceReport& report) { ++report.reconnects; });
                spdlog::info("{}: back, silent until the next field", _name);
            }
            catch (const DeviceError& error)
            {
                if (refusal != error.what()) // each reason once, not every quarter of a second
                    spdlog::warn("{}", error.what());
                refusal = error.what();
            }
            lock.lock();
            continue;
        }
        if (!work(lock))
            _wake.wait_for(lock, seconds(std::max(1e-3, nextDue_s() - base::steadySeconds())));
    }
}

double UsbArrayDevice::nextDue_s() const
{
    double due = std::min(_lastSubmit_s + protocol::kKeepAliveInterval_s,
                          _lastStatusAsked_s + kStatusInterval_s);
    if (_muteAwaited != 0) due = std::min(due, _muteAt_s + kMuteRetry_s);
    return due;
}

bool UsbArrayDevice::work(std::unique_lock<std::mutex>& lock)
{
    const double now_s = base::steadySeconds();
    if (_busy) return false; // who is at it wakes us when done
    if (_fault != Outcome::DONE)
    {
        recover(lock);
        return true;
    }
    // Asked several times, since a host that was stopped for a while hasn't heard anything either.
    if (now_s - _lastHeard_s > kSilentDevice_s && _asked >= kMostAsked)
    {
        lock.unlock();
        disconnect("gives no answer that this program understands since " +
                   base::shortNumber(kSilentDevice_s) + " s");
        lock.lock();
        return true;
    }
    // Answers come in order: what was heard so long after a field came after that field's own answer. The clock alone would
    // blame the device for a host whose threads don't get to run.
    if (!_flying.empty() && _flying.front().committed &&
        _lastHeard_s - _flying.front().submittedAt_s > kConfirm_s)
    {
        _flying.pop_front();
        _counters.change(
            [](DeviceReport& report)
            {
                ++report.lost;
                ++report.faults;
                report.message = "a field was never confirmed";
            });
        return true;
    }
    if (_muteAwaited != 0 && (_muteSent != _muteAwaited || now_s - _muteAt_s >= kMuteRetry_s) &&
        submitMute())
        return true;
    if (isCommitDue() && canHandOver())
    {
        submitCommit(lock);
        return true;
    }
    if (_slotFull && canSubmit())
    {
        submitField(lock);
        return true;
    }
    if (!_pool->hasFree()) return false;
    if (now_s - _lastStatusAsked_s >= kStatusInterval_s)
    {
        _lastStatusAsked_s = now_s;
        ++_asked;
        submitPacket(lock, Type::GET_STATUS);
        return true;
    }
    if (now_s - _lastSubmit_s >= protocol::kKeepAliveInterval_s)
    {
        submitPacket(lock, Type::KEEPALIVE);
        return true;
    }
    return false;
}

// Most of what happens needs no worker, and to wake a thread for nothing costs more than a field.
void UsbArrayDevice::wakeWorker()
{
    if (_slotFull || isCommitDue() || _fault != Outcome::DONE || _muteAwaited != 0)
        _wake.notify_all();
}

void UsbArrayDevice::release()
{
    _busy = false;
    _free.notify_all();
    wakeWorker();
}

void UsbArrayDevice::submitPacket(std::unique_lock<std::mutex>& lock, Type type)
{
    Packet packet;
    packet.type = type;
    _bytes.clear();
    protocol::append(_bytes, packet);
    _lastSubmit_s = base::steadySeconds();
    _busy = true;
    lock.unlock();
    _pool->send(0, _bytes);
    lock.lock();
    release();
}

bool UsbArrayDevice::submitMute()
{
    Packet mute;
    mute.type = Type::MUTE;
    mute.sequence = _muteAwaited;
    _muteBytes.clear();
    protocol::append(_muteBytes, mute);
    if (!_pool->control(
            _muteBytes)) // still busy with the one before: the worker tries again when that is through
        return false;
    _muteSent = _muteAwaited;
    _muteAt_s = base::steadySeconds();
    return true;
}

// A fault that the device survives: lift the stall and send the newest field again, whole. Else it is gone.
void UsbArrayDevice::recover(std::unique_lock<std::mutex>& lock)
{
    const Outcome fault = std::exchange(_fault, Outcome::DONE);
    const bool first = _faultsInRow == 0;
    const bool hopeless = fault == Outcome::LOST || ++_faultsInRow > kMostFaultsInRow;
    if (hopeless)
    {
        lock.unlock();
        disconnect(fault == Outcome::LOST
                       ? "unplugged"
                       : std::string(outcomeName(fault)) + " again and again, given up");
        lock.lock();
        return;
    }
    _busy = true; // nobody sends into a halted pipe
    lock.unlock();
    note(outcomeName(fault));
    if (first) spdlog::warn("{}: {}; the field is sent again", _name, outcomeName(fault));
    const bool lifted = _pool->clearHalt();
    lock.lock();
    release();
    if (!lifted)
    {
        lock.unlock();
        disconnect("unplugged");
        lock.lock();
        return;
    }
    const Joint left = settleFailed();
    if (left == nullptr) return;
    lock.unlock();
    left->leave(_seat.get());
    lock.lock();
}

// With _mutex held: the newest goes to the slot, for nobody to wait for.
UsbArrayDevice::Joint UsbArrayDevice::settleFailed()
{
    Joint left;
    std::uint64_t dropped = 0;
    std::uint64_t lost = 0;
    for (auto field = _flying.begin(); field != _flying.end();)
    {
        if (!field->failed)
        {
            ++field;
            continue;
        }
        if (field->joint != nullptr) left = std::move(field->joint);
        const bool newest = !_slotFull && field + 1 == _flying.end();
        if (newest && !field->repeated)
        {
            _slot = std::move(*field);
            _slot.repeated = true;
            _slot.failed = false;
            _slotFull = true;
        }
        else
            ++(newest ? lost : dropped);
        field = _flying.erase(field);
    }
    _counters.change(
        [&](DeviceReport& report)
        {
            report.dropped += dropped;
            report.lost += lost;
        });
    return left;
}

void UsbArrayDevice::onSent(std::uint64_t token, Outcome outcome)
{
    std::unique_lock<std::mutex> lock(_mutex);
    Joint staged;
    if (outcome == Outcome::DONE)
    {
        _faultsInRow = token == 0 ? _faultsInRow : 0;
        if (isStaged() && _flying.back().sequence == token) staged = _flying.back().joint;
    }
    else if (outcome != Outcome::CANCELLED)
    {
        if (_fault != Outcome::LOST) _fault = outcome;
        for (Field& field : _flying)
            if (field.sequence == token) field.failed = true;
        _heard.notify_all();
    }
    wakeWorker();
    lock.unlock();
    if (staged != nullptr) staged->ready(*_seat);
}

void UsbArrayDevice::onReceiveFailed(Outcome outcome)
{
    std::lock_guard<std::mutex> lock(_mutex);
    if (_fault != Outcome::LOST) _fault = outcome;
    _heard.notify_all();
    wakeWorker();
}

void UsbArrayDevice::onReceived(const std::uint8_t* bytes, std::size_t count)
{
    std::lock_guard<std::mutex> lock(_mutex);
    _parser.push(bytes, count);
    Packet packet;
    while (_parser.next(packet))
    {
        _lastHeard_s = base::steadySeconds();
        _asked = 0;
        if (packet.type == Type::INFO && packet.info.nonce == _nonce)
        {
            _info = packet;
            _greeted = true;
        }
        else if (packet.type == Type::STATUS)
            takeStatus(packet);
    }
    if (_parser.badPackets() != _nonsense)
    {
        const bool first = _nonsense == 0;
        _nonsense = _parser.badPackets();
        note("answers that are no packets");
        if (first) spdlog::warn("{}: answers that are no packets; ignored", _name);
    }
    _heard.notify_all();
    wakeWorker();
}

// With _mutex held. Every commit is answered, in order, so what is older than the one answered was not played.
void UsbArrayDevice::takeStatus(const Packet& packet)
{
    const protocol::Status& status = packet.status;
    const bool muted = (status.flags & protocol::PLAYING) == 0;
    if (muted && (_status.flags & protocol::PLAYING) != 0 && (status.flags & protocol::MUTED) == 0)
    {
        const char* why = (status.flags & protocol::WATCHDOG_FIRED) != 0 ? "muted by its watchdog"
                                                                         : "muted itself: too hot";
        note(why);
        spdlog::error("{}: {}", _name, why);
    }
    _status = status;
    std::uint64_t played = 0;
    std::uint64_t lost = 0;
    while (!_flying.empty() && packet.sequence != 0 &&
           !protocol::newer(_flying.front().sequence, packet.sequence))
    {
        const bool mine = _flying.front().sequence == status.lastPlayed;
        ++(mine ? played : lost);
        if (mine) _playing = std::move(_flying.front().signal);
        _flying.pop_front();
    }
    _counters.change(
        [&](DeviceReport& report)
        {
            report.played += played;
            report.lost += lost;
            report.temperature_C = status.temperature_dC / 10.0;
        });
    if (muted) std::fill(_playing.duty.begin(), _playing.duty.end(), std::uint8_t(0));
    if (_muteAwaited != 0 && packet.sequence != 0 &&
        !protocol::newer(_muteAwaited, packet.sequence))
        _muteAwaited = 0;
}

} // namespace midair::device
