#pragma once

#include <string>
#include <vector>

namespace midair::samples
{

/// Keeps in a file whether somebody muted the array and whether the program ended by itself, so
/// that a start without an operator does what the last one left: what was muted stays muted, what
/// played plays again. It is muted, too, after three crashes in ten minutes, and where the file
/// can't be understood.
class MuteMemory
{
public:
    static constexpr int kCrashes = 3;
    static constexpr double kCrashTime_s = 600.0;

    /// \a file: empty: nothing is kept. \a now_s: time of day, s since 1970.
    MuteMemory(std::string file, double now_s);

    bool startsMuted() const { return _isMuted; }
    /// Why it starts muted, and what is wrong with the file; empty: nothing.
    const std::string& reason() const { return _reason; }
    int crashes() const { return static_cast<int>(_crashes_s.size()); }

    /// Keeps a mute, or its end, which also forgets crashes, at once. Returns false if it can't be
    /// kept: the file can't be written.
    bool keep(bool isMuted);
    /// Notes that the program ends as it was asked to.
    bool end();

private:
    void read(double now_s);
    bool write() const;

    std::string _file;
    bool _isMuted = false;
    bool _isRunning = true;
    std::string _reason;
    std::vector<double> _crashes_s; ///< times of day of starts after a crash, in the last minutes
};

} // namespace midair::samples
