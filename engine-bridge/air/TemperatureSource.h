#pragma once

#include "haptics/base/threads/Mutex.h"

#include <optional>
#include <string>
#include <thread>

namespace midair::bridge
{

/// What a line of a temperature source says: a number from kLeastTemperature_C to
/// kMostTemperature_C, in C or with its unit, "21.3", "21.3 C". Returns nothing, and why in \a
/// problem, for anything else.
std::optional<double> temperatureOf(const std::string& line, std::string& problem);

/// Reads a thermometer's readings, a line each, from a regular file, whose last line is the newest,
/// or from a named pipe. A thread of its own looks four times a second, so that no caller waits for
/// a file.
class TemperatureSource
{
public:
    /// Longest line, and the part of a file's end that is read, bytes.
    static constexpr std::size_t kMostLine = 256;
    static constexpr std::size_t kMostRead = 4096;
    static constexpr double kLook_s = 0.25;

    /// What the thread has found since the last take().
    struct News
    {
        std::optional<double> temperature_C; ///< the newest good reading; none: there was none
        int bad = 0;                         ///< lines that are no reading
        std::string problem; ///< the newest of these, or why there is nothing to read; empty: none
        bool isClosed = false; ///< there is nothing to read now
    };

    explicit TemperatureSource(std::string file);
    ~TemperatureSource();
    TemperatureSource(const TemperatureSource&) = delete;
    TemperatureSource& operator=(const TemperatureSource&) = delete;

    const std::string& file() const { return _file; }
    News take(); ///< any thread; never waits for a file

private:
    void run();
    void look();
    bool isOpen();
    void readPipe();
    void readFile();
    void readLine(std::string line);
    void tell(const std::string& problem, bool isClosed);

    const std::string _file;
    int _descriptor = -1; // of a pipe
    std::string _seen;    // state and content of a regular file at the last look
    std::string _pending; // begin of a line
    bool _isTold = false; // all of _seen was read
    base::Mutex _mutex;
    News _news MIDAIR_GUARDED_BY(_mutex);
    bool _stop MIDAIR_GUARDED_BY(_mutex) = false;
    base::Condition _wake;
    std::thread _thread; // last, so that it starts after all others are made
};

} // namespace midair::bridge
