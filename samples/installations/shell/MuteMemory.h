#pragma once

#include "haptics/base/threads/Mutex.h"

#include <string>
#include <vector>

namespace midair::samples
{

/// Stores in a file whether the array is muted and whether the program ended properly, so that an
/// unattended restart continues in the same state. It starts muted also after three crashes in ten
/// minutes and if the file is invalid. A failure before the first frame doesn't count as a crash,
/// because nothing has played.
class MuteMemory
{
public:
    static constexpr std::size_t kCrashes = 3;
    static constexpr double kCrashTime_s = 600.0;

    /// \a file: empty for no file. \a now_s: time of day, s since 1970. Throws std::runtime_error
    /// if another program uses the file.
    MuteMemory(std::string file, double now_s);
    ~MuteMemory();

    MuteMemory(const MuteMemory&) = delete;
    MuteMemory& operator=(const MuteMemory&) = delete;

    bool startsMuted() const
    {
        const base::Lock lock(_changing);
        return _isMuted;
    }
    /// Returns why it starts muted, or what is wrong with the file; may be empty.
    const std::string& reason() const { return _reason; }
    /// Returns false if the reason says that the file can't be written.
    bool isWritable() const { return _isWritable; }
    int crashes() const
    {
        const base::Lock lock(_changing);
        return static_cast<int>(_crashes_s.size());
    }

    /// Stores a mute at once; an unmute also clears crashes. Returns false if the file can't be
    /// written. May be called from any thread, because frames may hang during a mute.
    bool keep(bool isMuted);
    /// Records that the program runs: from now on, ending without end() is a crash.
    bool begin();
    /// Records a proper end. begin() has no effect after it.
    bool end();

private:
    void lockFile();
    void read(double now_s) MIDAIR_REQUIRES(_changing);
    bool write() const MIDAIR_REQUIRES(_changing);

    const std::string _file;
    int _lock = -1; ///< descriptor of the lock file
    std::string _reason;
    bool _isWritable = true;
    mutable base::Mutex _changing; ///< guards the stored state
    bool _isMuted MIDAIR_GUARDED_BY(_changing) = false;
    bool _isRunning MIDAIR_GUARDED_BY(_changing) = false;
    bool _hasEnded MIDAIR_GUARDED_BY(_changing) = false;
    /// Times of recent restarts after a crash.
    std::vector<double> _crashes_s MIDAIR_GUARDED_BY(_changing);
};

} // namespace midair::samples
