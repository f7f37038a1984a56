#pragma once

#include "device/ArrayDevice.h"
#include "device/usb/Protocol.h"
#include "device/usb/UsbTransferPool.h"

#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>

namespace midair::device
{

/// An array that is plugged in, opened and greeted: it speaks our protocol and is the one that the
/// layout describes.
class UsbLink : private UsbTransferPool::Listener
{
public:
    using Outcome = UsbTransferPool::Outcome;

    /// Told on the pool's event thread, with no lock held, from the greeting on.
    class Owner
    {
    public:
        virtual ~Owner() = default;
        virtual void onSent(std::uint64_t token, Outcome outcome) = 0;
        virtual void onAnswer(const protocol::Packet& packet) = 0;
        virtual void onReceiveFailed(Outcome outcome) = 0;
        /// Bytes that are no packet; \a first: for the first time on this link.
        virtual void onNonsense(bool first) = 0;
    };

    /// Throws DeviceError: what UsbTransferPool says, no answer, another protocol version, another
    /// number of transducers or boards.
    UsbLink(const UsbAddress& address, const DeviceLayout& layout, Owner& owner);

    // Any thread; false when it can't be handed over now.

    bool hasFree() const { return _pool->hasFree(); }
    bool send(std::uint64_t token, const std::vector<std::uint8_t>& bytes)
    {
        return _pool->send(token, bytes);
    }
    bool send(protocol::Type type);       ///< a packet that is no more than its type
    bool mute(std::uint32_t sequence);    ///< overtakes all that waits in the pipe
    bool identify(int board, bool light); ///< overtakes as well; -1: all boards
    void cancelSends() { _pool->cancelSends(); }
    /// Lifts a stall; false when that fails. Not on the event thread.
    bool clearHalt() { return _pool->clearHalt(); }

    const std::string& name() const { return _pool->name(); }
    const protocol::Info& info() const { return _info.info; }

private:
    void greet();
    void check(const DeviceLayout& layout) const;

    void onSent(std::uint64_t token, Outcome outcome) override;
    void onReceived(const std::uint8_t* bytes, std::size_t count) override;
    void onReceiveFailed(Outcome outcome) override;
    void noteFault(Outcome outcome);

    Owner& _owner;
    const std::uint32_t _nonce;     ///< of our HELLO, and of the INFO that answers it
    protocol::StreamParser _parser; ///< the event thread's
    std::uint32_t _nonsense = 0;    ///< the event thread's
    std::mutex _mutex;              ///< of what follows, while greeting
    std::condition_variable _heard;
    bool _greeted = false;
    Outcome _fault = Outcome::DONE;
    protocol::Packet _info;
    std::unique_ptr<UsbTransferPool> _pool; ///< last: ends before what its thread calls
};

} // namespace midair::device
