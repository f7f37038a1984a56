#pragma once

#include <cstdint>
#include <vector>

#include <sys/types.h>

namespace midair::device
{

/// A child process that also holds a board's descriptor open. It writes the bytes that silence the
/// board if this process ends without the destructor, even by SIGKILL, or if beat() stops for half
/// a second, even by SIGSTOP.
///
/// For boards without a watchdog. The child closes all other descriptors, blocks every signal that
/// can be blocked, is named "midair-guard" in process lists, and ends with this object.
class SilenceOnCrash
{
public:
    /// The descriptor that the bytes are written to. \a endpoint: the bulk OUT endpoint (1 to 15)
    /// if \a descriptor belongs to usbfs and holds the claim of the interface; 0 if a plain write()
    /// does.
    struct Way
    {
        int descriptor = -1;
        unsigned endpoint = 0;
    };

    /// Starts the child and returns when nothing but SIGKILL to its own process number can end it
    /// any more (some ms, at most 5 s). It writes nothing before \a notBefore_s (steadySeconds()),
    /// since a board that is starting would lose it, nor within \a held_s after beat(true). If the
    /// child can't be started, a warning is logged and the board has no guard.
    SilenceOnCrash(const Way& way,
                   const std::vector<std::uint8_t>& bytes,
                   double notBefore_s = 0,
                   double held_s = 0);
    /// Ends the child without writing; it has closed the descriptor when this returns.
    ~SilenceOnCrash();

    SilenceOnCrash(const SilenceOnCrash&) = delete;
    SilenceOnCrash& operator=(const SilenceOnCrash&) = delete;

    /// Tells the child that this process is alive; to be called every 100 ms or so after the first
    /// call. One thread at a time. \a held: the board is in its bootloader, which it doesn't leave
    /// while it is sent anything.
    void beat(bool held = false);
    /// Has the child write now and end; returns true if the descriptor took all bytes. For a
    /// descriptor that this process can't write to any more.
    bool execute();

private:
    bool await(); ///< waits for the child's end; true if it wrote all bytes

    int _alive = -1; ///< end of a socket pair; if it closes without kFarewell, this process died
    pid_t _guard = -1;
};

} // namespace midair::device
