#include "device/JointCommit.h"

#include <algorithm>
#include <utility>

namespace midair::device
{

void SkewMeter::note(double skew_s)
{
    const base::Lock lock(_mutex);
    _reading.last_s = skew_s;
    _reading.worst_s = std::max(_reading.worst_s, skew_s);
}

SkewMeter::Reading SkewMeter::read() const
{
    const base::Lock lock(_mutex);
    return _reading;
}

void JointCommit::Seat::close()
{
    const base::Lock lock(_mutex);
    _device = nullptr;
}

JointCommit::Members::iterator JointCommit::find(const Seat* seat)
{
    return std::find_if(_members.begin(),
                        _members.end(),
                        [&](const Member& member) { return member.seat.get() == seat; });
}

bool JointCommit::join(std::shared_ptr<Seat> seat)
{
    const base::Lock lock(_mutex);
    if (_over) return false;
    _members.push_back({std::move(seat), false});
    return true;
}

void JointCommit::ready(const Seat& seat)
{
    Members commits;
    {
        const base::Lock lock(_mutex);
        const auto member = find(&seat);
        if (_over || member == _members.end() || member->ready) return;
        member->ready = true;
        commits = countDown();
    }
    tell(commits, true);
}

void JointCommit::leave(const Seat* seat)
{
    Members commits;
    {
        const base::Lock lock(_mutex);
        const auto member = find(seat);
        if (_over || (seat != nullptr && member == _members.end())) return;
        const bool counted = member != _members.end() && member->ready;
        if (member != _members.end()) _members.erase(member);
        if (!counted) commits = countDown();
    }
    tell(commits, true);
}

void JointCommit::giveUp()
{
    Members drops;
    {
        const base::Lock lock(_mutex);
        if (!_over) drops = end();
    }
    tell(drops, false);
}

JointCommit::Members JointCommit::countDown()
{
    return --_missing <= 0 ? end() : Members();
}

JointCommit::Members JointCommit::end()
{
    _over = true;
    return std::exchange(_members, {});
}

void JointCommit::tell(const Members& members, bool commits)
{
    for (const Member& member : members)
    {
        const base::Lock told(member.seat->_mutex);
        Device* const device = member.seat->_device;
        if (device == nullptr) continue;
        if (commits)
            device->commit(*this);
        else
            device->drop(*this);
    }
}

void JointCommit::handedOver(double at_s)
{
    const base::Lock lock(_mutex);
    _first_s = _out == 0 ? at_s : std::min(_first_s, at_s);
    _last_s = _out == 0 ? at_s : std::max(_last_s, at_s);
    if (++_out == _devices && _meter != nullptr) _meter->note(_last_s - _first_s);
}

} // namespace midair::device
