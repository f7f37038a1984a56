#pragma once

#include <osgMidair/HapticStatistics>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace midair::samples
{

/// What the command line says about the operator's page.
struct MonitorOptions
{
    std::string address; ///< "ADDRESS:PORT"; empty: there is no page
    /// file with the token that mutes and unmutes; made if it is missing. Empty: a new token with
    /// each start, which is printed
    std::string tokenFile;
    /// names of this machine, besides localhost and its own, under which the page is asked for
    std::vector<std::string> hosts;
};

/// What an installation says of itself at one moment.
struct MonitorReading
{
    osgMidair::HapticStatistics statistics;
    bool isMuted = false; ///< asked for; what the array does is statistics.state
    std::string array;    ///< that the newest field is for; empty before the first
};

/// A picture of the scene, ready to be sent.
struct MonitorPicture
{
    std::string jpeg;     ///< empty: there is none
    double taken_s = 0.0; ///< steady clock
};

/// What pictures cost, and why there are none.
struct PictureCost
{
    std::string problem;     ///< why there is no picture; empty: nothing is known to be wrong
    std::uint64_t count = 0; ///< taken so far
    double last_ms = 0.0;    ///< time that the thread that draws spent on the last one
    double most_ms = 0.0;    ///< on any
    double sum_ms = 0.0;     ///< on all
};

/// What the operator's page shows and mutes. All from any thread.
class MonitorSource
{
public:
    virtual ~MonitorSource() = default;
    MonitorSource() = default;
    MonitorSource(const MonitorSource&) = delete;
    MonitorSource& operator=(const MonitorSource&) = delete;

    /// Read ten times a second.
    virtual MonitorReading read() const = 0;
    virtual void setMuted(bool muted) = 0;
    /// Asks for pictures from now on for a while, and returns the newest; it may wait a moment for
    /// a first one.
    virtual MonitorPicture picture() { return {}; }
    virtual PictureCost pictureCost() const { return {"this program shows none"}; }
};

/// Serves the operator's page of an installation, of whatever kind its source is. For a scene:
/// SceneMonitor.
class Monitor
{
public:
    /// Serves from now on, and says where on stderr. \a name: of the program and what it shows.
    /// Throws std::runtime_error if options.address isn't understood or can't be listened on, or if
    /// the token's file can't be used: an operator relies on the page.
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
