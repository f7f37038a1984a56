#include "device/usb/UsbConnection.h"

#include "device/DeviceLog.h"
#include "haptics/base/threads/SteadyClock.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

namespace midair::device
{

using protocol::Packet;
using protocol::Type;

namespace
{

constexpr double kGreeting_s = 0.5;
constexpr double kConfirm_s = 0.5;
constexpr int kMostFaultsInRow = 5;

// New for each greeting, so that an answer to an earlier one isn't taken for this one's.
std::uint32_t newNonce()
{
    static std::atomic<std::uint32_t> count{0};
    const auto now_ns = static_cast<std::uint64_t>(base::steadySeconds() * 1e9);
    return ++count ^ static_cast<std::uint32_t>(now_ns);
}

std::vector<std::uint8_t> bytesOf(const Packet& packet)
{
    std::vector<std::uint8_t> bytes;
    protocol::append(bytes, packet);
    return bytes;
}

} // namespace

UsbLink::UsbLink(const UsbAddress& address, const DeviceLayout& layout, Owner& owner) :
    _owner(owner),
    _nonce(newNonce()),
    _pool(std::make_unique<UsbTransferPool>(address, static_cast<Listener&>(*this)))
{
    greet();
    check(layout);
}

void UsbLink::greet()
{
    Packet hello;
    hello.type = Type::HELLO;
    hello.nonce = _nonce;
    hello.watchdog_ms = static_cast<std::uint16_t>(std::lround(protocol::kWatchdog_s * 1000));
    _pool->send(0, bytesOf(hello));
    const double until_s = base::steadySeconds() + kGreeting_s;
    base::Lock lock(_mutex);
    while (!_greeted && _fault == Outcome::DONE && _heard.waitUntil_s(lock, until_s))
    {
    }
    if (_greeted) return;
    if (_fault != Outcome::DONE)
        throw DeviceError(name() + ": refuses the greeting: " + outcomeName(_fault));
    throw DeviceError(name() + ": gives no valid answer; does it run osgMidair's firmware?");
}

void UsbLink::check(const DeviceLayout& layout) const
{
    const protocol::Info& info = _info.info;
    if (_info.version != protocol::kVersion)
        throw DeviceError(fmt::format(
            "{}: firmware {} speaks protocol version {}, this program speaks {}: update the {}",
            name(),
            info.firmware(),
            int(_info.version),
            int(protocol::kVersion),
            _info.version < protocol::kVersion ? "firmware" : "program"));
    const std::vector<protocol::Range> ranges = protocol::ranges(layout);
    const int boards = ranges.empty() ? 0 : ranges.back().board + 1;
    if (info.transducers != static_cast<std::uint32_t>(layout.transducers) || info.boards != boards)
        throw DeviceError(
            fmt::format("{}: has {} transducers on {} boards, but the array file has {} on {}",
                        name(),
                        info.transducers,
                        info.boards,
                        layout.transducers,
                        boards));
}

bool UsbLink::send(Type type)
{
    Packet packet;
    packet.type = type;
    return _pool->send(0, bytesOf(packet));
}

bool UsbLink::mute(std::uint32_t sequence)
{
    Packet packet;
    packet.type = Type::MUTE;
    packet.sequence = sequence;
    return _pool->control(bytesOf(packet));
}

bool UsbLink::identify(int board, bool light)
{
    Packet packet;
    packet.type = Type::IDENTIFY;
    packet.board = board < 0 ? protocol::kAllBoards : static_cast<std::uint16_t>(board);
    packet.light = light;
    return _pool->control(bytesOf(packet));
}

void UsbLink::noteFault(Outcome outcome)
{
    {
        const base::Lock lock(_mutex);
        if (_fault != Outcome::LOST) _fault = outcome;
    }
    _heard.notifyAll();
}

void UsbLink::onSent(std::uint64_t token, Outcome outcome)
{
    if (outcome != Outcome::DONE && outcome != Outcome::CANCELLED) noteFault(outcome);
    _owner.onSent(token, outcome);
}

void UsbLink::onReceiveFailed(Outcome outcome)
{
    noteFault(outcome);
    _owner.onReceiveFailed(outcome);
}

void UsbLink::onReceived(const std::uint8_t* bytes, std::size_t count)
{
    _parser.push(bytes, count);
    Packet packet;
    while (_parser.next(packet))
    {
        if (packet.type == Type::INFO && packet.info.nonce == _nonce)
        {
            const base::Lock lock(_mutex);
            if (!_greeted) _info = packet;
            _greeted = true;
        }
        _owner.onAnswer(packet);
    }
    if (_parser.badPackets() != _nonsense)
    {
        const bool first = _nonsense == 0;
        _nonsense = _parser.badPackets();
        _owner.onNonsense(first);
    }
    _heard.notifyAll();
}

UsbConnection::UsbConnection(const DeviceLayout& layout, const std::string& name) :
    _ranges(protocol::ranges(layout)),
    _seat(new JointCommit::Seat(*this)),
    _playing(layout.transducers),
    _name(name)
{
}

// The link's destructor waits for callbacks that need _mutex, so the link is destroyed without the
// lock, here and after detach().
UsbConnection::~UsbConnection()
{
    std::unique_ptr<UsbLink> link;
    const base::Lock lock(_mutex);
    link = std::move(_link);
}

void UsbConnection::become(State state)
{
    if (_state != State::CLOSING) _state = state;
}

void UsbConnection::begin()
{
    const base::Lock lock(_mutex);
    become(State::GREETING);
    _session = {};
}

void UsbConnection::attach(std::unique_ptr<UsbLink> link, bool isBack)
{
    const base::Lock lock(_mutex);
    become(State::READY);
    _link = std::move(link);
    _name = _link->name();
    _session.clock.start(base::steadySeconds());
    _counters.change(
        [&, firmware = _link->info().firmware()](DeviceReport& report)
        {
            report.state = DeviceState::READY;
            report.firmware = firmware;
            report.reconnects += isBack ? 1 : 0;
        });
}

std::unique_ptr<UsbLink> UsbConnection::detach(const std::string& why)
{
    std::unique_ptr<UsbLink> link;
    std::vector<Joint> joints;
    {
        base::Lock lock(_mutex);
        while (_busy)
            _changed.wait(lock);
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
    _changed.notifyAll();
    for (const Joint& joint : joints)
        joint->leave(_seat.get());
    return link;
}

void UsbConnection::close(double atMost_s)
{
    _seat->close();
    mute();
    {
        const double until_s = base::steadySeconds() + atMost_s;
        base::Lock lock(_mutex);
        while (_mute.isAwaited() && _link != nullptr && _changed.waitUntil_s(lock, until_s))
        {
        }
        _state = State::CLOSING;
    }
    _wake.notifyAll();
}

bool UsbConnection::canHandOver() const
{
    return !_busy && _link != nullptr && _session.fault == Outcome::DONE && _link->hasFree();
}

// Wakes the worker only if it has work: waking costs more than sending a field.
void UsbConnection::wakeWorker()
{
    if (_queue.waits() || _queue.isCommitDue() || _session.fault != Outcome::DONE ||
        _mute.isAwaited())
        _wake.notifyAll();
}

template<typename Action>
bool UsbConnection::alone(Action&& action)
{
    _busy = true;
    UsbLink& link = *_link; // its removal waits until nobody is busy
    bool isDone = false;
    {
        const base::Unlocked unlocked(_mutex); // the pool may call onSent() at once
        isDone = action(link);
    }
    _busy = false;
    _changed.notifyAll();
    wakeWorker();
    return isDone;
}

bool UsbConnection::send(const DriveSignal& signal, const Joint& joint)
{
    const double now_s = base::steadySeconds();
    base::Lock lock(_mutex);
    const bool taken = signal.fits(_playing.transducers()) && _state == State::READY;
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
            submitField();
        else
            wakeWorker();
    }
    lock.unlock();
    if (leaves) joint->leave();
    if (overtaken != nullptr) overtaken->giveUp();
    return taken;
}

std::uint32_t UsbConnection::nextSequence()
{
    return _session.sequence = nextAfter(_session.sequence);
}

void UsbConnection::submitField()
{
    const FieldQueue::Field& field = _queue.takeOff(nextSequence());
    _bytes.clear();
    protocol::appendData(_bytes, field.signal, _ranges, field.sequence);
    if (field.committed) protocol::appendCommit(_bytes, field.signal.size(), field.sequence);
    handOver();
}

void UsbConnection::submitCommit()
{
    FieldQueue::Field& field = _queue.newest();
    field.committed = true;
    _bytes.clear();
    protocol::appendCommit(_bytes, field.signal.size(), field.sequence);
    handOver();
}

// Sends _bytes, which belong to the newest field in flight.
void UsbConnection::handOver()
{
    FieldQueue::Field& field = _queue.newest();
    const bool sounds = field.committed;
    const Joint joint = sounds ? std::move(field.joint) : nullptr;
    field.submittedAt_s = base::steadySeconds();
    _session.clock.onSubmit(field.submittedAt_s);
    alone(
        [&, token = field.sequence, sentAt_s = field.sentAt_s](UsbLink& link)
        {
            if (!link.send(token, _bytes)) return false;
            if (!sounds) return true;
            const double now_s = base::steadySeconds();
            if (joint != nullptr) joint->handedOver(now_s);
            _counters.noteHandedOver(now_s, sentAt_s);
            return true;
        });
}

void UsbConnection::commit(const JointCommit& joint)
{
    const base::Lock lock(_mutex);
    if (!_queue.releaseFor(joint)) return;
    if (canHandOver())
        submitCommit();
    else
        wakeWorker();
}

void UsbConnection::drop(const JointCommit& joint)
{
    const base::Lock lock(_mutex);
    if (_queue.dropFor(joint) && _queue.waits() && canSubmit()) submitField();
}

// Fields that still reach the device have smaller sequence numbers than the MUTE and never play. A
// repeated request keeps its number, so a late answer counts.
void UsbConnection::mute()
{
    std::vector<Joint> joints;
    {
        const base::Lock lock(_mutex);
        joints = _queue.settleAll(false);
        _playing.clear();
        if (_link != nullptr)
        {
            const bool isAsked = _mute.awaits(_session.sequence);
            _mute.ask(isAsked ? _session.sequence : nextSequence(), base::steadySeconds());
            submitMute();
            _link->cancelSends();
            _wake.notifyAll();
        }
    }
    for (const Joint& joint : joints)
        joint->giveUp();
}

// Returns false while the last control transfer is in flight; the worker then tries again.
bool UsbConnection::submitMute()
{
    if (!_link->mute(_mute.sequence())) return false;
    _mute.onSent(base::steadySeconds());
    return true;
}

std::string UsbConnection::work()
{
    base::Lock lock(_mutex);
    while (_state != State::CLOSING)
    {
        const double now_s = base::steadySeconds();
        if (!_busy && _session.fault != Outcome::DONE)
        {
            std::string why = recover();
            if (!why.empty()) return why;
        }
        else if (!_busy && _session.clock.isDeviceSilent(now_s))
            return fmt::format("has given no valid answer for {:g} s", LinkClock::kSilentDevice_s);
        else if (_busy || !workOnce()) // alone() wakes this thread when it ends
        {
            double due_s = _session.clock.nextDue_s();
            if (_mute.isAwaited()) due_s = std::min(due_s, _mute.nextDue_s());
            _wake.waitUntil_s(lock, std::max(due_s, base::steadySeconds() + 1e-3));
        }
    }
    return {};
}

bool UsbConnection::workOnce()
{
    const double now_s = base::steadySeconds();
    // Answers come in order, so an answer this long after a field came after that field's own
    // answer. The present time would blame the device when the host's threads don't run.
    if (_queue.loseUnconfirmed(_session.clock.heard_s(), kConfirm_s))
    {
        _counters.countFault("a field was never confirmed");
        return true;
    }
    if (_mute.isDue(now_s) && submitMute()) return true;
    if (_queue.isCommitDue() && canHandOver())
    {
        submitCommit();
        return true;
    }
    if (_queue.waits() && canSubmit())
    {
        submitField();
        return true;
    }
    const bool asks = _session.clock.isQuestionDue(now_s);
    if (!_link->hasFree() || (!asks && !_session.clock.isKeepAliveDue(now_s))) return false;
    if (asks) _session.clock.onQuestion(now_s);
    _session.clock.onSubmit(now_s);
    alone([&](UsbLink& link) { return link.send(asks ? Type::GET_STATUS : Type::KEEPALIVE); });
    return true;
}

// Recovers from a fault: clears the stall and sends the newest field again. Returns the reason if
// the link must be given up.
std::string UsbConnection::recover()
{
    const Outcome fault = std::exchange(_session.fault, Outcome::DONE);
    if (fault == Outcome::LOST) return "unplugged";
    if (++_session.faultsInRow > kMostFaultsInRow)
        return std::string(outcomeName(fault)) + " repeatedly, given up";
    _counters.countFault(outcomeName(fault));
    if (_session.faultsInRow == 1)
        deviceLog().warn("{}: {}; the field is sent again", _name, outcomeName(fault));
    // The field is sent again only when the pipe is no longer halted.
    if (!alone([](UsbLink& link) { return link.clearHalt(); })) return "unplugged";
    const Joint left = _queue.repeatFailed();
    if (left == nullptr) return {};
    const base::Unlocked unlocked(_mutex);
    left->leave(_seat.get());
    return {};
}

void UsbConnection::noteFault(Outcome outcome)
{
    if (_session.fault != Outcome::LOST) _session.fault = outcome;
    _changed.notifyAll();
    wakeWorker();
}

void UsbConnection::onSent(std::uint64_t token, Outcome outcome)
{
    Joint staged;
    {
        const base::Lock lock(_mutex);
        const auto sequence = static_cast<std::uint32_t>(token);
        if (outcome == Outcome::DONE)
        {
            if (token != 0) _session.faultsInRow = 0;
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
    const base::Lock lock(_mutex);
    noteFault(outcome);
}

void UsbConnection::onNonsense(bool first)
{
    _counters.countFault("invalid answers");
    if (first) deviceLog().warn("{}: invalid answers; ignored", name());
}

void UsbConnection::onAnswer(const Packet& packet)
{
    {
        const base::Lock lock(_mutex);
        _session.clock.onAnswer(base::steadySeconds());
        if (packet.type == Type::STATUS) takeStatus(packet);
        wakeWorker();
    }
    _changed.notifyAll();
}

// Every commit is answered, in order, so older fields than the answered one were not played.
void UsbConnection::takeStatus(const Packet& packet)
{
    const protocol::Status& status = packet.status;
    const bool muted = (status.flags & protocol::PLAYING) == 0;
    if (muted && (_session.flags & protocol::PLAYING) != 0 && (status.flags & protocol::MUTED) == 0)
    {
        const char* why = (status.flags & protocol::WATCHDOG_FIRED) != 0 ? "muted by its watchdog"
                                                                         : "muted itself: too hot";
        _counters.countFault(why);
        deviceLog().error("{}: {}", _name, why);
    }
    _session.flags = status.flags;
    if (auto playing = _queue.settleUntil(packet.sequence, status.lastPlayed))
        _playing.replace(*playing);
    if (muted) _playing.clear();
    _mute.onAnswer(packet.sequence);
    _counters.change([&](DeviceReport& report)
                     { report.temperature_C = status.temperature_dC / 10.0; });
}

} // namespace midair::device
