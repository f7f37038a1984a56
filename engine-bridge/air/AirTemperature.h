#pragma once

#include "haptics/base/text/MessageLog.h"
#include "haptics/base/threads/Mutex.h"
#include "haptics/base/threads/SteadyClock.h"

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

namespace midair::bridge
{

/// Parses a line of a temperature source: a number from kLeastTemperature_C to kMostTemperature_C,
/// in C or with its unit, "21.3", "21.3 C". Returns nothing, with the reason in \a problem, for
/// other lines.
std::optional<double> temperatureOf(const std::string& line, std::string& problem);

/// Reads a thermometer, one reading a line, from a regular file, whose last line is the newest, or
/// from a named pipe. A separate thread looks four times a second, so that no caller waits for a
/// file.
class TemperatureSource
{
public:
    /// Longest line, and length of the end of a file that is read, bytes.
    static constexpr std::size_t kMostLine = 256;
    static constexpr std::size_t kMostRead = 4096;
    static constexpr double kLook_s = 0.25;

    /// Results of the thread since the last take().
    struct News
    {
        std::optional<double> temperature_C; ///< the newest good reading; none: there was none
        int bad = 0;                         ///< invalid lines
        std::string problem; ///< newest problem of a line, or why nothing can be read; empty: none
        bool isClosed = false; ///< there is nothing to read now
    };

    /// \a clock outlives it.
    explicit TemperatureSource(std::string file, const base::Clock& clock = base::steadyClock());
    ~TemperatureSource();
    TemperatureSource(const TemperatureSource&) = delete;
    TemperatureSource& operator=(const TemperatureSource&) = delete;

    News take(); ///< any thread; never waits for a file

private:
    void run();
    void look();
    void readPipe();
    void readFile();
    void readLine(const std::string& line);
    void tell(const std::string& problem, bool isClosed);

    const std::string _file;
    const base::Clock& _clock;
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

/// The temperature used for solving: the setting, or a followed source. It changes in small steps,
/// so that fields continue from the last one without audible or perceptible jumps.
///
/// Follows the median of the last three good readings, so that a single wrong one has no effect.
/// Without a good reading for kStale_s the last one is kept: rooms change slowly, and a wrong
/// temperature costs only accuracy; no cap depends on it by more than a percent in 5 K.
class AirTemperature
{
public:
    static constexpr double kStep_K = 0.1;   ///< largest step
    static constexpr double kLeast_K = 0.05; ///< smaller differences are ignored
    static constexpr double kPause_s = 0.2;  ///< between two steps: 0.5 K/s at most
    static constexpr double kStale_s = 60.0; ///< time without a good reading

    /// \a log gets each kind of problem once until it has ended.
    explicit AirTemperature(base::MessageLog& log) : _log(log) {}

    /// Follows \a file from now on; empty: no source. No change if it is the same.
    void setSource(const std::string& file);

    const std::string& source() const { return _name; }

    /// Returns the present temperature, C; \a now_s on the steady clock. \a set_C is the setting:
    /// it applies at once without a source, and is the start of a source's steps.
    double at(double now_s, double set_C);

    /// The same with the readings in \a news instead of the source's.
    double follow(const TemperatureSource::News& news, double now_s, double set_C);

private:
    void listen(const TemperatureSource::News& news, double now_s);
    double median() const;
    void tellOnce(const char* trouble, const std::string& what);
    void ends(const char* trouble);

    base::MessageLog& _log;
    std::unique_ptr<TemperatureSource> _source;
    std::string _name;             // of the source, for messages
    std::array<double, 3> _last{}; // newest good readings
    int _readings = 0;             // of _last
    double _now_C = 0.0;           // temperature for solving
    bool _follows = false;         // _now_C is known
    double _heard_s = 0.0;         // of the last good reading, or of the source's begin
    double _bad_s = 0.0;           // of the last bad one
    double _stepped_s = 0.0;
    bool _hasBegun = false;
};

} // namespace midair::bridge
