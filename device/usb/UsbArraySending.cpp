#include "device/usb/UsbArrayDevice.h"

namespace midair::device
{

using Outcome = UsbTransferPool::Outcome;

bool UsbArrayDevice::canHandOver() const
{
    return !_busy && _pool != nullptr && _fault == Outcome::DONE && _pool->hasFree();
}

// Data of a newer field would make a commit that is still to come incomplete.
bool UsbArrayDevice::canSubmit() const
{
    return _flying.size() < kMostFlying && !isStaged() && canHandOver();
}

bool UsbArrayDevice::isStaged() const
{
    return !_flying.empty() && !_flying.back().committed;
}

bool UsbArrayDevice::isCommitDue() const
{
    return isStaged() && _flying.back().released;
}

bool UsbArrayDevice::isHeldBackFor(const JointCommit& joint) const
{
    return isStaged() && !_flying.back().released && _flying.back().joint.get() == &joint;
}

bool UsbArrayDevice::sendTogether(const DriveSignal& signal, const Joint& joint)
{
    const double now_s = base::steadySeconds();
    std::unique_lock<std::mutex> lock(_mutex);
    const bool whole =
        signal.size() == _layout.transducers && signal.duty.size() == signal.phase.size();
    const bool taken = whole && _ready && !_closing;
    const bool leaves = joint != nullptr && (!taken || _flying.size() >= kMostFlying);
    Joint overtaken;
    if (!taken)
        _counters.countRefused();
    else if (joint != nullptr && !leaves && !joint->join(_seat))
        _counters.change(
            [](DeviceReport& report)
            {
                ++report.sent;
                ++report.dropped;
            });
    else
    {
        overtaken = fillSlot(signal, now_s, leaves ? nullptr : joint);
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

// With _mutex held; gives the joint whose field is overtaken. A field without one takes the place in the joint of the one that it
// overtakes: it is the same field, which a guard sends again with another gain.
UsbArrayDevice::Joint
UsbArrayDevice::fillSlot(const DriveSignal& signal, double sentAt_s, const Joint& joint)
{
    _counters.change(
        [&](DeviceReport& report)
        {
            ++report.sent;
            report.dropped += _slotFull ? 1 : 0;
        });
    Joint overtaken;
    if (!_slotFull || joint != nullptr)
    {
        if (_slotFull) overtaken = std::move(_slot.joint);
        _slot.joint = joint;
    }
    _slot.signal = signal;
    _slot.sentAt_s = sentAt_s;
    _slot.released = _slot.committed = _slot.failed = _slot.repeated = false;
    _slotFull = true;
    return overtaken;
}

void UsbArrayDevice::submitField(std::unique_lock<std::mutex>& lock)
{
    _flying.push_back(std::move(_slot));
    _slotFull = false;
    Field& field = _flying.back();
    field.sequence = nextSequence();
    field.committed = field.joint == nullptr;
    _bytes.clear();
    protocol::appendData(_bytes, field.signal, _ranges, field.sequence);
    if (field.committed) protocol::appendCommit(_bytes, field.signal.size(), field.sequence);
    handOver(lock);
}

void UsbArrayDevice::submitCommit(std::unique_lock<std::mutex>& lock)
{
    Field& field = _flying.back();
    field.committed = true;
    _bytes.clear();
    protocol::appendCommit(_bytes, field.signal.size(), field.sequence);
    handOver(lock);
}

// _bytes, of the last of _flying.
void UsbArrayDevice::handOver(std::unique_lock<std::mutex>& lock)
{
    Field& field = _flying.back();
    const bool sounds = field.committed;
    const Joint joint = sounds ? std::move(field.joint) : nullptr;
    field.submittedAt_s = _lastSubmit_s = base::steadySeconds();
    const std::uint32_t token = field.sequence;
    const double sentAt_s = field.sentAt_s;
    _busy = true;
    lock.unlock(); // the pool may tell the listener at once
    const bool handedOver = _pool->send(token, _bytes);
    if (handedOver && sounds)
    {
        const double now_s = base::steadySeconds();
        if (joint != nullptr) joint->handedOver(now_s);
        _counters.change(
            [&](DeviceReport& report)
            {
                report.lastHandedOver_s = now_s;
                report.latency_s = now_s - sentAt_s;
            });
    }
    lock.lock();
    release();
}

void UsbArrayDevice::commit(const JointCommit& joint)
{
    std::unique_lock<std::mutex> lock(_mutex);
    if (!isHeldBackFor(joint)) return;
    _flying.back().released = true;
    if (canHandOver())
        submitCommit(lock);
    else
        wakeWorker();
}

void UsbArrayDevice::drop(const JointCommit& joint)
{
    std::unique_lock<std::mutex> lock(_mutex);
    const bool waiting = _slotFull && _slot.joint.get() == &joint;
    if (!waiting && !isHeldBackFor(joint)) return;
    if (waiting)
        _slotFull = false;
    else
        _flying.pop_back();
    _counters.change([](DeviceReport& report) { ++report.dropped; });
    if (_slotFull && canSubmit()) submitField(lock);
}

} // namespace midair::device
