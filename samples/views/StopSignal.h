#pragma once

#include <functional>

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

} // namespace midair::samples
