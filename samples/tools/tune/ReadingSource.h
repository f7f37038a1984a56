#pragma once

#include <functional>
#include <string>

#include <sys/types.h>

namespace midair::samples
{

/// What came of waiting for a line.
enum class LineState
{
    LINE,
    END,      ///< nothing will come any more
    TIME_OUT, ///< nothing came in time
    STOPPED   ///< the caller's word
};

/// Lines of an instrument: of stdin, of a file or a pipe, or of a command that is run for it.
class ReadingSource
{
public:
    /// \a name: "-" for stdin, "exec:COMMAND", or the path of a file or named pipe. Throws
    /// base::InputError.
    explicit ReadingSource(const std::string& name);
    ~ReadingSource(); ///< ends the command
    ReadingSource(const ReadingSource&) = delete;
    ReadingSource& operator=(const ReadingSource&) = delete;

    /// Tells the instrument which row plays now, where it reads requests: a command on its stdin,
    /// who stands behind "-" on stdout. It need not listen.
    void request(const std::string& line);

    /// Waits for a line, at most \a limit_s. \a goesOn is called every few milliseconds; where it
    /// returns false, the wait ends.
    LineState next(std::string& line, double limit_s, const std::function<bool()>& goesOn);

    /// Drops all that has come so far, for instruments that write by their own clock.
    void drop();

private:
    void open(const std::string& path);
    void run(const std::string& command);
    void closeRequests();
    bool take(std::string& line);
    bool fill(int wait_ms); ///< false: the end of what isn't a growing file

    int _in = -1;
    int _requests = -1;
    bool _grows = false; ///< a regular file: more may be written to it
    bool _ended = false;
    pid_t _child = -1;
    std::string _buffer;
};

} // namespace midair::samples
