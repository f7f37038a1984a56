#include "device/JointCommit.h"

#include <algorithm>
#include <utility>

namespace midair::device
{

void JointCommit::Seat::close()
{
    std::lock_guard<std::mutex> lock(_mutex);
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
    std::lock_guard<std::mutex> lock(_mutex);
    if (_over) return false;
    _members.push_back({std::move(seat), false});
    return true;
}

void JointCommit::ready(const Seat& seat)
{
    std::unique_lock<std::mutex> lock(_mutex);
    const auto member = find(&seat);
    if (_over || member == _members.end() || member->ready) return;
    member->ready = true;
    countDown(lock);
}

void JointCommit::leave(const Seat* seat)
{
    std::unique_lock<std::mutex> lock(_mutex);
    const auto member = find(seat);
    if (_over || (seat != nullptr && member == _members.end())) return;
    const bool counted = member != _members.end() && member->ready;
    if (member != _members.end()) _members.erase(member);
    if (!counted) countDown(lock);
}

void JointCommit::giveUp()
{
    std::unique_lock<std::mutex> lock(_mutex);
    if (!_over) end(lock, &Device::drop);
}

void JointCommit::countDown(std::unique_lock<std::mutex>& lock)
{
    if (--_missing <= 0) end(lock, &Device::commit);
}

void JointCommit::end(std::unique_lock<std::mutex>& lock, Message message)
{
    _over = true;
    const Members members = std::move(_members);
    _members.clear();
    lock.unlock();
    for (const Member& member : members)
    {
        std::lock_guard<std::mutex> told(member.seat->_mutex);
        if (member.seat->_device != nullptr) (member.seat->_device->*message)(*this);
    }
}

} // namespace midair::device
