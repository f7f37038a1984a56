#pragma once

#include <memory>
#include <mutex>
#include <vector>

namespace midair::device
{

/// One field that several devices play at one moment: each says when it has its piece, and with the last of them all commit.
///
/// Nobody waits in here, and no lock of it is held over commit() and drop(): they come on the stack of whoever brought the end about,
/// with ready(), leave() or giveUp(). So call these three with no lock held that a device's commit() or drop() takes; join() under any.
class JointCommit
{
public:
    /// What takes part. Told at most one of the two for a field, from any thread.
    class Device
    {
    public:
        virtual ~Device() = default;
        virtual void
        commit(const JointCommit& joint) = 0; ///< all are ready: the piece is to sound now
        virtual void drop(const JointCommit& joint) = 0; ///< one gave it up: it shall not sound
    };

    /// A device's place in joints, which may outlive it.
    class Seat
    {
    public:
        explicit Seat(Device& device) : _device(&device) {}
        void
        close(); ///< the device is told nothing any more once this returns; not out of commit() or drop()

    private:
        friend class JointCommit;
        std::mutex _mutex; ///< held while the device is told
        Device* _device;
    };

    /// Ends when so many are ready or have left; each of them joins or leaves once.
    explicit JointCommit(int devices) : _missing(devices) {}

    /// Makes no calls. False when the field was given up already: then it is to be dropped and nothing more to be told to us.
    bool join(std::shared_ptr<Seat> seat);
    void ready(const Seat& seat);
    /// The others play without it; null: who has not joined. In vain after the end.
    void leave(const Seat* seat = nullptr);
    /// Nobody who is in it plays the field. In vain after the end.
    void giveUp();

private:
    struct Member
    {
        std::shared_ptr<Seat> seat;
        bool ready;
    };
    using Members = std::vector<Member>;
    using Message = void (Device::*)(const JointCommit&);

    void countDown(std::unique_lock<std::mutex>& lock);
    void end(std::unique_lock<std::mutex>& lock, Message message);
    Members::iterator find(const Seat* seat);

    std::mutex _mutex;
    int _missing; ///< neither ready nor gone
    bool _over = false;
    Members _members;
};

} // namespace midair::device
