#pragma once

#include <atomic>
#include <functional>
#include <thread>

namespace midair::samples
{

/// From now on SIGUSR1 asks to mute the array and SIGUSR2 to let it play: for a switch on the wall,
/// a script, `systemctl kill --signal=USR1`. One that comes before there is a MuteSignals waits.
void catchMuteSignals();

/// Follows these signals on a thread of its own, so that a mute holds where frames hang. One at a
/// time.
class MuteSignals
{
public:
    /// \a follow: called with true to mute, with false to let play. \a keep: called afterwards, and
    /// when wake() asks for it; it may wait for a disk.
    explicit MuteSignals(std::function<void(bool)> follow, std::function<void()> keep = {});
    ~MuteSignals();
    MuteSignals(const MuteSignals&) = delete;
    MuteSignals& operator=(const MuteSignals&) = delete;

    /// Has keep called soon; returns at once. Any thread.
    void wake();
    /// Returns once what has come so far is followed; nothing is followed from then on.
    void end();

private:
    void run();

    std::function<void(bool)> _follow;
    std::function<void()> _keep;
    std::atomic<bool> _isAsked{false}; ///< by wake()
    std::atomic<bool> _isEnding{false};
    std::thread _thread;
};

} // namespace midair::samples
