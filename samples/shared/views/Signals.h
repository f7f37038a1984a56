#pragma once

#include <atomic>
#include <functional>
#include <thread>

namespace midair::samples
{

/// From now on Ctrl-C (SIGINT), SIGTERM and SIGHUP (unless it was ignored, as by nohup) ask the
/// program to end after its frame, so that the array falls silent and reports are written. The
/// second one ends it at once, as without this.
///
/// Where the frame hangs, so that nobody asks isStopAsked(), a thread silences the array (see
/// SilenceAtStop) and ends the program by the same signal, within 2 s. What the program does after
/// it has asked may take 10 s.
void catchStopSignals();

/// Returns true once one of them came. From the program's loop, any thread.
bool isStopAsked();

/// While it exists, \a silence is called before a program is ended that doesn't end by itself. One
/// at a time.
class SilenceAtStop
{
public:
    /// \a silence is called from a thread of its own; if it hangs, the program ends all the same.
    explicit SilenceAtStop(std::function<void()> silence);
    ~SilenceAtStop(); ///< waits for a call under way
    SilenceAtStop(const SilenceAtStop&) = delete;
    SilenceAtStop& operator=(const SilenceAtStop&) = delete;
};

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
