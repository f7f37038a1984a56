#pragma once

#include <cstdint>
#include <vector>

#include <sys/types.h>

namespace midair::device
{

/// A child process that holds a board's descriptor open too and, when this process ends without a farewell, be it by SIGKILL, writes
/// the bytes that silence the board.
///
/// For boards without a watchdog. The child holds nothing else of this process, and ends with this object.
class LastWill
{
public:
    /// What the bytes are written to. \a endpoint: the bulk OUT endpoint (1 to 15) where \a descriptor is usbfs's and holds the claim
    /// of the interface; 0 where the bytes are just written.
    struct Way
    {
        int descriptor = -1;
        unsigned endpoint = 0;
    };

    /// Where no child can be had, that is logged and the board goes without.
    LastWill(const Way& way, const std::vector<std::uint8_t>& bytes);
    ~LastWill(); ///< the farewell: nothing is written, and the child has let go of the descriptor when this returns

    LastWill(const LastWill&) = delete;
    LastWill& operator=(const LastWill&) = delete;

private:
    int _alive = -1; ///< one end of a socket: closed without a word means that this process died
    pid_t _guard = -1;
};

} // namespace midair::device
