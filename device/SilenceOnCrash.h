#pragma once

#include <cstdint>
#include <vector>

#include <sys/types.h>

namespace midair::device
{

/// A guard process that also holds a board's descriptor open. It writes the bytes that silence the
/// board if this process ends without the destructor, even by SIGKILL, or if beat() stops for half
/// a second, even by SIGSTOP.
///
/// For boards without a watchdog. The guard closes all other descriptors, blocks all blockable
/// signals, is named "midair-guard" in process lists, and ends with this object.
class SilenceOnCrash
{
public:
    /// Descriptor for the bytes. \a endpoint: the bulk OUT endpoint (1 to 15) if \a descriptor
    /// belongs to usbfs and holds the claim of the interface; 0 for a plain write().
    struct Way
    {
        int descriptor = -1;
        unsigned endpoint = 0;
    };

    /// Starts the guard and returns when only SIGKILL to its own process number can end it (some
    /// ms, at most 5 s). It writes nothing before \a notBefore_s (steadySeconds()), because a
    /// starting board would lose it, nor within \a held_s after beat(true). If the guard can't be
    /// started, a warning is logged and the board has no guard.
    SilenceOnCrash(const Way& way,
                   const std::vector<std::uint8_t>& bytes,
                   double notBefore_s = 0,
                   double held_s = 0);
    /// Ends the guard without writing; it has closed the descriptor when this returns.
    ~SilenceOnCrash();

    SilenceOnCrash(const SilenceOnCrash&) = delete;
    SilenceOnCrash& operator=(const SilenceOnCrash&) = delete;

    /// Tells the guard that this process is alive; call it every 100 ms or so after the first call.
    /// One thread at a time. \a held: the board is in its bootloader, and stays there while it
    /// receives bytes.
    void beat(bool held = false);
    /// Makes the guard write now and end; returns true if the descriptor took all bytes. For a
    /// descriptor that this process can't write to any more.
    bool execute();

private:
    bool await(); ///< waits for the guard's end; true if it wrote all bytes

    int _alive = -1; ///< end of a socket pair; if it closes without kFarewell, this process died
    pid_t _guard = -1;
};

} // namespace midair::device
