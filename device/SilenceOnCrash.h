#pragma once

#include <cstdint>
#include <vector>

#include <sys/types.h>

namespace midair::device
{

/// A child process that holds a board's descriptor open too and writes the bytes that silence the
/// board when this process ends without a farewell, be it by SIGKILL, or gives no sign of life for
/// half a second, be it by SIGSTOP.
///
/// For boards without a watchdog. The child holds nothing else of this process, takes no signal
/// that can be refused, is called "midair-guard" wherever processes are looked up by name, and ends
/// with this object.
class SilenceOnCrash
{
public:
    /// What the bytes are written to. \a endpoint: the bulk OUT endpoint (1 to 15) where \a
    /// descriptor is usbfs's and holds the claim of the interface; 0 where the bytes are just
    /// written.
    struct Way
    {
        int descriptor = -1;
        unsigned endpoint = 0;
    };

    /// Nothing is written before \a notBefore_s (steadySeconds()), for a board that is still
    /// starting and would lose it, nor in the \a held_s after a sign of life that says so. Where no
    /// child can be had, that is logged and the board goes without.
    SilenceOnCrash(const Way& way,
                   const std::vector<std::uint8_t>& bytes,
                   double notBefore_s = 0,
                   double held_s = 0);
    ~SilenceOnCrash(); ///< the farewell: nothing is written, and the child has let go of the
                       ///< descriptor when this returns

    SilenceOnCrash(const SilenceOnCrash&) = delete;
    SilenceOnCrash& operator=(const SilenceOnCrash&) = delete;

    /// A sign of life, to be given every 100 ms or so once the first was given. One thread at a
    /// time. \a held: the board is in its bootloader, which stays as long as it is sent something.
    void beat(bool held = false);
    /// The child writes now and ends; whether the descriptor took all of it. For a way that this
    /// process can't write to any more.
    bool execute();

private:
    bool await(); ///< the child's end; whether it wrote what it had to

    int _alive = -1; ///< one end of a socket: closed without a word means that this process died
    pid_t _guard = -1;
};

} // namespace midair::device
