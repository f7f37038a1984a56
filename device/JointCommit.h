#pragma once

#include "haptics/base/threads/Mutex.h"

#include <memory>
#include <utility>
#include <vector>

namespace midair::device
{

/// Measures the time between the first and the last commit of the devices in a joint.
class SkewMeter
{
public:
    /// Seconds, for the last joint in which all devices played, and the largest so far.
    struct Reading
    {
        double last_s = 0;
        double worst_s = 0;
    };
    void note(double skew_s);
    Reading read() const;

private:
    mutable base::Mutex _mutex;
    Reading _reading MIDAIR_GUARDED_BY(_mutex);
};

/// A field that several devices start to play together: each reports when it has its part, and when
/// the last one does, all commit.
///
/// No call waits. The thread whose ready(), leave() or giveUp() ends the joint calls commit() and
/// drop() without holding a lock of the joint. So call these three without any lock that a device's
/// commit() or drop() takes; other members may be called under any lock.
class JointCommit
{
public:
    /// A participating device. For each field at most one of commit() and drop() is called, from
    /// any thread.
    class Device
    {
    public:
        virtual ~Device() = default;
        /// All devices are ready: play the part now.
        virtual void commit(const JointCommit& joint) = 0;
        /// A device gave the field up: don't play it.
        virtual void drop(const JointCommit& joint) = 0;
    };

    /// Reference of a device in joints, which may outlive the device.
    class Seat
    {
    public:
        explicit Seat(Device& device) : _device(&device) {}
        /// After this returns, commit() and drop() are not called any more. Must not be called
        /// within them.
        void close();

    private:
        friend class JointCommit;
        base::Mutex _mutex; ///< held during commit() and drop()
        Device* _device MIDAIR_GUARDED_BY(_mutex);
    };

    /// Ends when \a devices have become ready or left; each of them joins or leaves once. \a meter
    /// may be null.
    explicit JointCommit(int devices, std::shared_ptr<SkewMeter> meter = nullptr) :
        _devices(devices),
        _meter(std::move(meter)),
        _missing(devices)
    {
    }

    /// Adds a device. Returns false if the joint has ended: the device then drops the field and
    /// makes no more calls. Doesn't call commit() or drop().
    bool join(std::shared_ptr<Seat> seat);
    /// Reports that the device has its part of the field.
    void ready(const Seat& seat);
    /// Removes a device, so the others play without it; null: one that has not joined. No effect
    /// after the end.
    void leave(const Seat* seat = nullptr);
    /// Gives the field up for all devices. No effect after the end.
    void giveUp();
    /// Reports that a device sent its commit at \a at_s of base::steadySeconds().
    void handedOver(double at_s);

private:
    /// A joined device, and whether it has its part.
    struct Member
    {
        std::shared_ptr<Seat> seat;
        bool ready;
    };
    using Members = std::vector<Member>;

    /// Returns the devices to call after _mutex is released.
    Members countDown() MIDAIR_REQUIRES(_mutex);
    Members end() MIDAIR_REQUIRES(_mutex);
    void tell(const Members& members, bool commits) MIDAIR_EXCLUDES(_mutex);
    Members::iterator find(const Seat* seat) MIDAIR_REQUIRES(_mutex);

    const int _devices;
    const std::shared_ptr<SkewMeter> _meter;
    base::Mutex _mutex;
    int _missing MIDAIR_GUARDED_BY(_mutex); ///< devices that are neither ready nor gone
    int _out MIDAIR_GUARDED_BY(_mutex) = 0; ///< commits sent
    double _first_s MIDAIR_GUARDED_BY(_mutex) = 0;
    double _last_s MIDAIR_GUARDED_BY(_mutex) = 0;
    bool _over MIDAIR_GUARDED_BY(_mutex) = false;
    Members _members MIDAIR_GUARDED_BY(_mutex);
};

} // namespace midair::device
