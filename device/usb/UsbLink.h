#pragma once

#include "device/ArrayDevice.h"
#include "device/usb/Protocol.h"
#include "device/usb/UsbTransferPool.h"
#include "haptics/base/threads/Mutex.h"

#include <memory>
#include <string>

namespace midair::device
{

/// A connection to an array that is plugged in, opened and greeted: the array speaks osgMidair's
/// protocol and matches the layout.
class UsbLink : private UsbTransferPool::Listener
{
public:
    using Outcome = UsbTransferPool::Outcome;

    /// Gets the link's events, on the pool's event thread, with no lock held, from the greeting on.
    class Owner
    {
    public:
        virtual ~Owner() = default;
        /// The transfer of send() with \a token ended; 0: a packet other than a field.
        virtual void onSent(std::uint64_t token, Outcome outcome) = 0;
        virtual void onAnswer(const protocol::Packet& packet) = 0;
        /// No answers come any more until clearHalt().
        virtual void onReceiveFailed(Outcome outcome) = 0;
        /// Bytes came that are no packet; \a first: for the first time on this link.
        virtual void onNonsense(bool first) = 0;
    };

    /// Throws DeviceError as UsbTransferPool does, and if the array doesn't answer or has another
    /// protocol version, number of transducers or number of boards.
    UsbLink(const UsbAddress& address, const DeviceLayout& layout, Owner& owner);

    // These may be called from any thread; those that send return false if no transfer is free or
    // the array is gone.

    bool hasFree() const { return _pool->hasFree(); }
    bool send(std::uint64_t token, const std::vector<std::uint8_t>& bytes)
    {
        return _pool->send(token, bytes);
    }
    bool send(protocol::Type type);       ///< sends a packet without payload
    bool mute(std::uint32_t sequence);    ///< goes by the control endpoint, so it overtakes fields
    bool identify(int board, bool light); ///< goes by the control endpoint; -1: all boards
    void cancelSends() { _pool->cancelSends(); }
    /// Clears a stall; returns false if that fails. Must not be called on the event thread.
    bool clearHalt() { return _pool->clearHalt(); }

    const std::string& name() const { return _pool->name(); }
    /// After the greeting nothing writes it any more.
    const protocol::Info& info() const MIDAIR_NO_THREAD_ANALYSIS { return _info.info; }

private:
    void greet();
    /// Reads _info without the lock: after the greeting nothing writes it any more.
    void check(const DeviceLayout& layout) const MIDAIR_NO_THREAD_ANALYSIS;

    void onSent(std::uint64_t token, Outcome outcome) override;
    void onReceived(const std::uint8_t* bytes, std::size_t count) override;
    void onReceiveFailed(Outcome outcome) override;
    void noteFault(Outcome outcome);

    Owner& _owner;
    const std::uint32_t _nonce;     ///< sent in HELLO; the INFO that answers it has the same
    protocol::StreamParser _parser; ///< used by the event thread only
    std::uint32_t _nonsense = 0;    ///< bad packets reported; used by the event thread only
    base::Mutex _mutex;
    base::Condition _heard;
    bool _greeted MIDAIR_GUARDED_BY(_mutex) = false;
    Outcome _fault MIDAIR_GUARDED_BY(_mutex) = Outcome::DONE;
    protocol::Packet _info MIDAIR_GUARDED_BY(_mutex);
    std::unique_ptr<UsbTransferPool> _pool; ///< last: its thread uses all other members
};

} // namespace midair::device
