#include "device/FieldQueue.h"

#include "device/SequenceNumber.h"

#include <algorithm>
#include <utility>

namespace midair::device
{

void FieldQueue::refuse()
{
    ++_sent;
    ++_refused;
}

void FieldQueue::dropBeforehand()
{
    ++_sent;
    ++_dropped;
}

FieldQueue::Joint FieldQueue::put(const DriveSignal& signal, double sentAt_s, const Joint& joint)
{
    ++_sent;
    if (_waits) ++_dropped;
    Joint overtaken;
    if (!_waits || joint != nullptr)
    {
        if (_waits) overtaken = std::move(_waiting.joint);
        _waiting.joint = joint;
    }
    _waiting.signal = signal;
    _waiting.sentAt_s = sentAt_s;
    _waiting.released = _waiting.committed = _waiting.failed = _waiting.repeated = false;
    _waits = true;
    return overtaken;
}

FieldQueue::Field& FieldQueue::takeOff(std::uint32_t sequence)
{
    _flying.push_back(std::move(_waiting));
    _waits = false;
    Field& field = _flying.back();
    field.sequence = sequence;
    field.committed = field.joint == nullptr;
    return field;
}

FieldQueue::Joint FieldQueue::stagedAs(std::uint32_t sequence) const
{
    return isStaged() && _flying.back().sequence == sequence ? _flying.back().joint : nullptr;
}

bool FieldQueue::holdsBackFor(const JointCommit& joint) const
{
    return isStaged() && !_flying.back().released && _flying.back().joint.get() == &joint;
}

bool FieldQueue::releaseFor(const JointCommit& joint)
{
    if (!holdsBackFor(joint)) return false;
    _flying.back().released = true;
    return true;
}

bool FieldQueue::dropFor(const JointCommit& joint)
{
    if (_waits && _waiting.joint.get() == &joint)
        _waits = false;
    else if (holdsBackFor(joint))
        _flying.pop_back();
    else
        return false;
    ++_dropped;
    return true;
}

std::optional<DriveSignal> FieldQueue::settleUntil(std::uint32_t sequence, std::uint32_t lastPlayed)
{
    std::optional<DriveSignal> playing;
    while (!_flying.empty() && sequence != 0 && !newer(_flying.front().sequence, sequence))
    {
        const bool mine = _flying.front().sequence == lastPlayed;
        ++(mine ? _played : _lost);
        if (mine)
        {
            playing = std::move(_flying.front().signal);
            _confirmed_s = std::max(_confirmed_s, _flying.front().sentAt_s);
        }
        _flying.pop_front();
    }
    return playing;
}

bool FieldQueue::loseUnconfirmed(double heardAt_s, double confirm_s)
{
    if (_flying.empty() || !_flying.front().committed ||
        heardAt_s - _flying.front().submittedAt_s <= confirm_s)
        return false;
    loseOldest();
    return true;
}

void FieldQueue::dropFlying()
{
    _dropped += _flying.size();
    _flying.clear();
}

void FieldQueue::loseOldest()
{
    _flying.pop_front();
    ++_lost;
}

void FieldQueue::dropWaiting()
{
    _dropped += _waits ? 1 : 0;
    _waits = false;
}

void FieldQueue::fail(std::uint32_t sequence)
{
    for (Field& field : _flying)
        if (field.sequence == sequence) field.failed = true;
}

FieldQueue::Joint FieldQueue::repeatFailed()
{
    Joint left;
    for (auto field = _flying.begin(); field != _flying.end();)
    {
        if (!field->failed)
        {
            ++field;
            continue;
        }
        if (field->joint != nullptr) left = std::move(field->joint);
        const bool newest = !_waits && field + 1 == _flying.end();
        if (newest && !field->repeated)
        {
            _waiting = std::move(*field);
            _waiting.repeated = true;
            _waiting.failed = false;
            _waits = true;
        }
        else
            ++(newest ? _lost : _dropped);
        field = _flying.erase(field);
    }
    return left;
}

std::vector<FieldQueue::Joint> FieldQueue::settleAll(bool deviceIsLost)
{
    std::vector<Joint> joints;
    if (_waits && _waiting.joint != nullptr) joints.push_back(std::move(_waiting.joint));
    if (isStaged()) joints.push_back(std::move(_flying.back().joint));
    dropWaiting();
    (deviceIsLost ? _lost : _dropped) += _flying.size();
    _flying.clear();
    return joints;
}

void FieldQueue::addTo(DeviceReport& report) const
{
    report.sent += _sent;
    report.played += _played;
    report.dropped += _dropped;
    report.lost += _lost;
    report.refused += _refused;
    report.pending += pending();
}

} // namespace midair::device
