#pragma once

#include <osgMidair/HapticStatistics>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace midair::samples
{

/// Command-line options of the operator's page.
struct MonitorOptions
{
    std::string address; ///< "ADDRESS:PORT"; empty: no page
    /// file with the token for mute and unmute; created if missing. Empty: a new token at each
    /// start, which is printed
    std::string tokenFile;
    /// names of this machine, besides localhost and its own, that browsers may use for the page
    std::vector<std::string> hosts;
};

/// The state of an installation at one moment.
struct MonitorReading
{
    osgMidair::HapticStatistics statistics;
    bool isMuted = false; ///< mute requested; the array's actual state is statistics.state
    std::string array;    ///< array of the newest field; empty before the first
};

/// A picture of the scene as JPEG.
struct MonitorPicture
{
    std::string jpeg;     ///< empty: there is none
    double taken_s = 0.0; ///< steady clock
};

/// The cost of pictures, and why there is none.
struct PictureCost
{
    std::string problem;     ///< why there is no picture; empty: no known problem
    std::uint64_t count = 0; ///< pictures taken so far
    double last_ms = 0.0;    ///< time that the last one took on the drawing thread
    double most_ms = 0.0;    ///< largest of these times
    double sum_ms = 0.0;     ///< sum of these times
};

/// Data source and mute of the operator's page. All functions may be called from any thread.
class MonitorSource
{
public:
    virtual ~MonitorSource() = default;
    MonitorSource() = default;
    MonitorSource(const MonitorSource&) = delete;
    MonitorSource& operator=(const MonitorSource&) = delete;

    /// Called ten times a second.
    virtual MonitorReading read() const = 0;
    virtual void setMuted(bool muted) = 0;
    /// Requests pictures for a while and returns the newest; it may wait shortly for a first one.
    virtual MonitorPicture picture() { return {}; }
    virtual PictureCost pictureCost() const { return {"this program shows none"}; }
};

/// Serves the operator's page of any MonitorSource. For a scene use SceneMonitor.
class Monitor
{
public:
    /// Starts serving and prints the address on stderr. \a name: the program and what it shows.
    /// Throws std::runtime_error if options.address is invalid or can't be listened on, or if the
    /// token's file can't be used, because an operator relies on the page.
    Monitor(const MonitorOptions& options,
            const std::string& name,
            std::shared_ptr<MonitorSource> source);
    ~Monitor();
    Monitor(const Monitor&) = delete;
    Monitor& operator=(const Monitor&) = delete;

    int port() const { return _port; }
    const std::string& token() const { return _token; }

private:
    class Page;

    int _port = 0;
    std::string _token;
    std::shared_ptr<Page> _page;
};

} // namespace midair::samples
