#pragma once

#include "haptics/base/threads/Mutex.h"

#include <string>
#include <vector>

namespace midair::samples
{

/// Keeps in a file whether somebody muted the array and whether the program ended by itself, so
/// that a start without an operator does what the last one left: what was muted stays muted, what
/// played plays again. It is muted, too, after three crashes in ten minutes, and where the file
/// can't be understood. A start that fails before the first frame is no crash: nothing has played.
class MuteMemory
{
public:
    static constexpr std::size_t kCrashes = 3;
    static constexpr double kCrashTime_s = 600.0;

    /// \a file: empty: nothing is kept. \a now_s: time of day, s since 1970. Throws
    /// std::runtime_error if another program has the file.
    MuteMemory(std::string file, double now_s);
    ~MuteMemory();

    MuteMemory(const MuteMemory&) = delete;
    MuteMemory& operator=(const MuteMemory&) = delete;

    bool startsMuted() const
    {
        const base::Lock lock(_changing);
        return _isMuted;
    }
    /// Why it starts muted, and what is wrong with the file; empty: nothing.
    const std::string& reason() const { return _reason; }
    int crashes() const
    {
        const base::Lock lock(_changing);
        return static_cast<int>(_crashes_s.size());
    }

    /// Keeps a mute, or its end, which also forgets crashes, at once. Returns false if it can't be
    /// kept: the file can't be written. Any thread, as frames may hang while somebody mutes.
    bool keep(bool isMuted);
    /// Notes that it runs: from now on whatever ends it without end() is a crash.
    bool begin();
    /// Notes that the program ends as it was asked to.
    bool end();

private:
    void lockFile();
    void read(double now_s) MIDAIR_REQUIRES(_changing);
    bool write() const MIDAIR_REQUIRES(_changing);

    const std::string _file;
    int _lock = -1; ///< a file beside it, locked as long as this lives
    std::string _reason;
    mutable base::Mutex _changing; ///< what is kept
    bool _isMuted MIDAIR_GUARDED_BY(_changing) = false;
    bool _isRunning MIDAIR_GUARDED_BY(_changing) = false;
    /// Times of day of starts after a crash, in the last minutes.
    std::vector<double> _crashes_s MIDAIR_GUARDED_BY(_changing);
};

} // namespace midair::samples
