#pragma once

#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace midair::device
{

/// How far apart the devices of joints were handed their commits: of the last joint that all of its
/// devices played in, and the most.
class SkewMeter
{
public:
    struct Reading
    {
        double last_s = 0;
        double worst_s = 0;
    };
    void note(double skew_s);
    Reading read() const;

private:
    mutable std::mutex _mutex;
    Reading _reading;
};

/// One field that several devices play at one moment: each says when it has its piece, and with the
/// last of them all commit.
///
/// Nobody waits in here, and no lock of it is held over commit() and drop(): they come on the stack
/// of whoever brought the end about, with ready(), leave() or giveUp(). So call these three with no
/// lock held that a device's commit() or drop() takes; the others under any.
class JointCommit
{
public:
    /// What takes part. Told at most one of commit() and drop() for a field, from any thread.
    class Device
    {
    public:
        virtual ~Device() = default;
        /// All are ready: the piece is to sound now.
        virtual void commit(const JointCommit& joint) = 0;
        /// One gave the field up: it shall not sound.
        virtual void drop(const JointCommit& joint) = 0;
    };

    /// A device's place in joints, which may outlive it.
    class Seat
    {
    public:
        explicit Seat(Device& device) : _device(&device) {}
        /// The device is told nothing any more once this returns. Not to be called by what it is
        /// told.
        void close();

    private:
        friend class JointCommit;
        std::mutex _mutex; ///< held while the device is told
        Device* _device;
    };

    /// Ends when so many are ready or have left; each of them joins or leaves once.
    explicit JointCommit(int devices, std::shared_ptr<SkewMeter> meter = nullptr) :
        _devices(devices),
        _missing(devices),
        _meter(std::move(meter))
    {
    }

    /// Makes no calls. False when the field was given up already: then it is to be dropped and
    /// nothing more to be told to us.
    bool join(std::shared_ptr<Seat> seat);
    void ready(const Seat& seat);
    /// The others play without it; null: who has not joined. In vain after the end.
    void leave(const Seat* seat = nullptr);
    /// Nobody who is in it plays the field. In vain after the end.
    void giveUp();
    /// The commit went out, at this time of std::chrono::steady_clock.
    void handedOver(double at_s);

private:
    struct Member
    {
        std::shared_ptr<Seat> seat;
        bool ready;
    };
    using Members = std::vector<Member>;

    void countDown(std::unique_lock<std::mutex>& lock);
    void end(std::unique_lock<std::mutex>& lock, bool commits);
    Members::iterator find(const Seat* seat);

    const int _devices;
    std::mutex _mutex;
    int _missing; ///< neither ready nor gone
    int _out = 0; ///< commits handed over
    double _first_s = 0;
    double _last_s = 0;
    const std::shared_ptr<SkewMeter> _meter;
    bool _over = false;
    Members _members;
};

} // namespace midair::device
