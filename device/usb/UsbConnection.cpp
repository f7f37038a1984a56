#include "device/usb/UsbConnection.h"

#include "device/DeviceLog.h"
#include "haptics/base/threads/SteadyClock.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

namespace midair::device
{

using protocol::Packet;
using protocol::Type;

namespace
{

constexpr double kConfirm_s = 0.5;
constexpr int kMostFaultsInRow = 5;

} // namespace

UsbConnection::UsbConnection(const DeviceLayout& layout, const std::string& name) :
    _layout(layout),
    _ranges(protocol::ranges(layout)),
    _playing(layout.transducers),
    _name(name),
    _seat(new JointCommit::Seat(*this))
{
}

// The link's destructor waits for callbacks that need _mutex, so the link is destroyed without the
// lock, here and after detach().
UsbConnection::~UsbConnection()
{
    std::unique_ptr<UsbLink> link;
    const std::lock_guard<std::mutex> lock(_mutex);
    link = std::move(_link);
}

void UsbConnection::become(State state)
{
    if (_state != State::CLOSING) _state = state;
}

void UsbConnection::begin()
{
    const std::lock_guard<std::mutex> lock(_mutex);
    become(State::GREETING);
    _sequence = 0;
    _fault = Outcome::DONE;
    _faultsInRow = 0;
    _flags = 0;
}

void UsbConnection::attach(std::unique_ptr<UsbLink> link, bool isBack)
{
    const std::lock_guard<std::mutex> lock(_mutex);
    become(State::READY);
    _link = std::move(link);
    _name = _link->name();
    _clock.start(base::steadySeconds());
    _counters.change(
        [&](DeviceReport& report)
        {
            report.state = DeviceState::READY;
            report.firmware = _link->info().firmware();
            report.reconnects += isBack ? 1 : 0;
        });
}

std::unique_ptr<UsbLink> UsbConnection::detach(const std::string& why)
{
    std::unique_ptr<UsbLink> link;
    std::vector<Joint> joints;
    {
        std::unique_lock<std::mutex> lock(_mutex);
        _free.wait(lock, [&] { return !_busy; });
        link = std::move(_link);
        become(State::AWAY);
        joints = _queue.settleAll(true);
        _playing.clear();
        _mute.forget();
        if (why.empty())
            _counters.change([](DeviceReport& report) { report.state = DeviceState::LOST; });
        else
            _counters.countLoss(why);
    }
    _heard.notify_all();
    for (const Joint& joint : joints)
        joint->leave(_seat.get());
    return link;
}

void UsbConnection::close(double atMost_s)
{
    _seat->close();
    mute();
    {
        std::unique_lock<std::mutex> lock(_mutex);
        _heard.wait_for(lock,
                        std::chrono::duration<double>(atMost_s),
                        [&] { return !_mute.isAwaited() || _link == nullptr; });
        _state = State::CLOSING;
    }
    _wake.notify_all();
}

bool UsbConnection::canHandOver() const
{
    return !_busy && _link != nullptr && _fault == Outcome::DONE && _link->hasFree();
}

// Wakes the worker only if it has something to do: waking it costs more than sending a field.
void UsbConnection::wakeWorker()
{
    if (_queue.waits() || _queue.isCommitDue() || _fault != Outcome::DONE || _mute.isAwaited())
        _wake.notify_all();
}

template<typename Action>
auto UsbConnection::alone(std::unique_lock<std::mutex>& lock, Action&& action)
{
    _busy = true;
    lock.unlock(); // the pool may call onSent() at once
    const auto result = action(*_link);
    lock.lock();
    _busy = false;
    _free.notify_all();
    wakeWorker();
    return result;
}

bool UsbConnection::send(const DriveSignal& signal, const Joint& joint)
{
    const double now_s = base::steadySeconds();
    std::unique_lock<std::mutex> lock(_mutex);
    const bool taken = signal.fits(_layout.transducers) && _state == State::READY;
    const bool leaves = joint != nullptr && (!taken || _queue.isFull());
    Joint overtaken;
    if (!taken)
        _queue.refuse();
    else if (joint != nullptr && !leaves && !joint->join(_seat))
        _queue.dropBeforehand();
    else
    {
        overtaken = _queue.put(signal, now_s, leaves ? nullptr : joint);
        if (canSubmit())
            submitField(lock);
        else
            wakeWorker();
    }
    lock.unlock();
    if (leaves) joint->leave();
    if (overtaken != nullptr) overtaken->giveUp();
    return taken;
}

void UsbConnection::submitField(std::unique_lock<std::mutex>& lock)
{
    const FieldQueue::Field& field = _queue.takeOff(_sequence = nextAfter(_sequence));
    _bytes.clear();
    protocol::appendData(_bytes, field.signal, _ranges, field.sequence);
    if (field.committed) protocol::appendCommit(_bytes, field.signal.size(), field.sequence);
    handOver(lock);
}

void UsbConnection::submitCommit(std::unique_lock<std::mutex>& lock)
{
    FieldQueue::Field& field = _queue.newest();
    field.committed = true;
    _bytes.clear();
    protocol::appendCommit(_bytes, field.signal.size(), field.sequence);
    handOver(lock);
}

// Sends _bytes, which belong to the newest field in flight.
void UsbConnection::handOver(std::unique_lock<std::mutex>& lock)
{
    FieldQueue::Field& field = _queue.newest();
    const bool sounds = field.committed;
    const Joint joint = sounds ? std::move(field.joint) : nullptr;
    field.submittedAt_s = base::steadySeconds();
    _clock.onSubmit(field.submittedAt_s);
    alone(lock,
          [&, token = field.sequence, sentAt_s = field.sentAt_s](UsbLink& link)
          {
              if (!link.send(token, _bytes)) return false;
              if (!sounds) return true;
              const double now_s = base::steadySeconds();
              if (joint != nullptr) joint->handedOver(now_s);
              _counters.change(
                  [&](DeviceReport& report)
                  {
                      report.lastHandedOver_s = now_s;
                      report.latency_s = now_s - sentAt_s;
                  });
              return true;
          });
}

void UsbConnection::commit(const JointCommit& joint)
{
    std::unique_lock<std::mutex> lock(_mutex);
    if (!_queue.releaseFor(joint)) return;
    if (canHandOver())
        submitCommit(lock);
    else
        wakeWorker();
}

void UsbConnection::drop(const JointCommit& joint)
{
    std::unique_lock<std::mutex> lock(_mutex);
    if (_queue.dropFor(joint) && _queue.waits() && canSubmit()) submitField(lock);
}

// Fields that still reach the device have smaller sequence numbers than the MUTE and never play.
// Asked again with nothing in between, it keeps its number: a late answer counts.
void UsbConnection::mute()
{
    std::vector<Joint> joints;
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        joints = _queue.settleAll(false);
        _playing.clear();
        if (_link != nullptr)
        {
            if (!_mute.awaits(_sequence)) _mute.ask(_sequence = nextAfter(_sequence));
            _muteAsked_s = base::steadySeconds();
            submitMute();
            _link->cancelSends();
            _wake.notify_all();
        }
    }
    for (const Joint& joint : joints)
        joint->giveUp();
}

// Returns false while the last control transfer is in flight; the worker tries again after it.
bool UsbConnection::submitMute()
{
    if (!_link->mute(_mute.sequence())) return false;
    _mute.onSent(base::steadySeconds());
    return true;
}

std::string UsbConnection::work()
{
    std::unique_lock<std::mutex> lock(_mutex);
    while (_state != State::CLOSING)
    {
        const double now_s = base::steadySeconds();
        if (!_busy && _fault != Outcome::DONE)
        {
            std::string why = recover(lock);
            if (!why.empty()) return why;
        }
        else if (!_busy && _clock.isDeviceSilent(now_s))
            return fmt::format("gives no answer that this program understands since {:g} s",
                               LinkClock::kSilentDevice_s);
        else if (_busy || !workOnce(lock)) // alone() wakes this thread when it ends
        {
            double due_s = _clock.nextDue_s();
            if (_mute.isAwaited()) due_s = std::min(due_s, _mute.nextDue_s());
            _wake.wait_for(
                lock, std::chrono::duration<double>(std::max(1e-3, due_s - base::steadySeconds())));
        }
    }
    return {};
}

bool UsbConnection::workOnce(std::unique_lock<std::mutex>& lock)
{
    const double now_s = base::steadySeconds();
    // Answers come in order, so an answer this long after a field came after that field's own
    // answer. The time now would blame the device when the host's threads don't get to run.
    if (_queue.loseUnconfirmed(_clock.heard_s(), kConfirm_s))
    {
        _counters.countFault("a field was never confirmed");
        return true;
    }
    if (_mute.isDue(now_s) && submitMute()) return true;
    if (_queue.isCommitDue() && canHandOver())
    {
        submitCommit(lock);
        return true;
    }
    if (_queue.waits() && canSubmit())
    {
        submitField(lock);
        return true;
    }
    const bool asks = _clock.isQuestionDue(now_s);
    if (!_link->hasFree() || (!asks && !_clock.isKeepAliveDue(now_s))) return false;
    if (asks) _clock.onQuestion(now_s);
    _clock.onSubmit(now_s);
    alone(lock,
          [&](UsbLink& link) { return link.send(asks ? Type::GET_STATUS : Type::KEEPALIVE); });
    return true;
}

// Recovers from a fault: clears the stall and sends the newest field again. Returns the reason if
// the link has to be given up.
std::string UsbConnection::recover(std::unique_lock<std::mutex>& lock)
{
    const Outcome fault = std::exchange(_fault, Outcome::DONE);
    if (fault == Outcome::LOST) return "unplugged";
    if (++_faultsInRow > kMostFaultsInRow)
        return std::string(outcomeName(fault)) + " again and again, given up";
    _counters.countFault(outcomeName(fault));
    if (_faultsInRow == 1)
        deviceLog().warn("{}: {}; the field is sent again", _name, outcomeName(fault));
    // The field is sent again only once the pipe isn't halted any more.
    if (!alone(lock, [](UsbLink& link) { return link.clearHalt(); })) return "unplugged";
    const Joint left = _queue.repeatFailed();
    if (left == nullptr) return {};
    lock.unlock();
    left->leave(_seat.get());
    lock.lock();
    return {};
}

void UsbConnection::noteFault(Outcome outcome)
{
    if (_fault != Outcome::LOST) _fault = outcome;
    _heard.notify_all();
    wakeWorker();
}

void UsbConnection::onSent(std::uint64_t token, Outcome outcome)
{
    Joint staged;
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        const auto sequence = static_cast<std::uint32_t>(token);
        if (outcome == Outcome::DONE)
        {
            if (token != 0) _faultsInRow = 0;
            staged = _queue.stagedAs(sequence);
        }
        else if (outcome != Outcome::CANCELLED)
        {
            noteFault(outcome);
            _queue.fail(sequence);
        }
    }
    if (staged != nullptr) staged->ready(*_seat);
}

void UsbConnection::onReceiveFailed(Outcome outcome)
{
    const std::lock_guard<std::mutex> lock(_mutex);
    noteFault(outcome);
}

void UsbConnection::onNonsense(bool first)
{
    _counters.countFault("answers that are no packets");
    if (first) deviceLog().warn("{}: answers that are no packets; ignored", name());
}

void UsbConnection::onAnswer(const Packet& packet)
{
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        _clock.onAnswer(base::steadySeconds());
        if (packet.type == Type::STATUS) takeStatus(packet);
        wakeWorker();
    }
    _heard.notify_all();
}

// Every commit is answered, in order, so older fields than the one answered were not played.
void UsbConnection::takeStatus(const Packet& packet)
{
    const protocol::Status& status = packet.status;
    const bool muted = (status.flags & protocol::PLAYING) == 0;
    if (muted && (_flags & protocol::PLAYING) != 0 && (status.flags & protocol::MUTED) == 0)
    {
        const char* why = (status.flags & protocol::WATCHDOG_FIRED) != 0 ? "muted by its watchdog"
                                                                         : "muted itself: too hot";
        _counters.countFault(why);
        deviceLog().error("{}: {}", _name, why);
    }
    _flags = status.flags;
    if (auto playing = _queue.settleUntil(packet.sequence, status.lastPlayed))
        _playing.replace(*playing);
    if (muted) _playing.clear();
    const bool wasAwaited = _mute.isAwaited();
    _mute.onAnswer(packet.sequence);
    if (wasAwaited && !_mute.isAwaited()) _muted_s = _muteAsked_s;
    _counters.change([&](DeviceReport& report)
                     { report.temperature_C = status.temperature_dC / 10.0; });
}

} // namespace midair::device
