#pragma once

#include <atomic>
#include <functional>
#include <thread>

namespace midair::samples
{

/// Makes Ctrl-C (SIGINT), SIGTERM and SIGHUP (unless ignored, as with nohup) ask the program to end
/// after its frame, so that the array falls silent and reports are written. A second signal ends it
/// at once.
///
/// If the frame hangs and isStopAsked() is not called, a thread silences the array (see
/// SilenceAtStop) and ends the program with the same signal, within 2 s. After isStopAsked() has
/// returned true, the program has 10 s to end.
void catchStopSignals();

/// Returns true once one of these signals has come. May be called from any thread.
bool isStopAsked();

/// While it exists, \a silence is called before a program is ended that doesn't end by itself, and
/// \a asked as soon as it is asked to end. One at a time.
class SilenceAtStop
{
public:
    /// Both are called from threads of their own; if one hangs, the program ends all the same. \a
    /// asked may wait for a disk.
    explicit SilenceAtStop(std::function<void()> silence, std::function<void()> asked = {});
    ~SilenceAtStop(); ///< waits for a call under way
    SilenceAtStop(const SilenceAtStop&) = delete;
    SilenceAtStop& operator=(const SilenceAtStop&) = delete;
};

/// Makes SIGUSR1 mute and SIGUSR2 unmute the array: for a switch on the wall, a script, `systemctl
/// kill --signal=USR1`. A signal that comes before a MuteSignals exists is kept.
void catchMuteSignals();

/// Follows these signals on a separate thread, so that a mute works even if frames hang. Only one
/// may exist.
class MuteSignals
{
public:
    /// \a follow is called with true to mute, with false to unmute. \a keep is called afterwards
    /// and after wake(); it may block on a disk.
    explicit MuteSignals(std::function<void(bool)> follow, std::function<void()> keep = {});
    ~MuteSignals();
    MuteSignals(const MuteSignals&) = delete;
    MuteSignals& operator=(const MuteSignals&) = delete;

    /// Requests a call of keep and returns at once. May be called from any thread.
    void wake();
    /// Follows signals received so far, then stops.
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
