#pragma once

#include <osgMidair/HapticStatistics>

#include <cstdint>
#include <string>

namespace midair::samples
{

/// What an installation says of itself at one moment.
struct MonitorReading
{
    osgMidair::HapticStatistics statistics;
    bool isMuted = false; ///< asked for; what the array does is statistics.state
    std::string array;    ///< that the newest field is for; empty before the first
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
};

/// A picture of the scene, ready to be sent.
struct MonitorPicture
{
    std::string bytes;    ///< empty: there is none
    std::string type;     ///< "image/jpeg"
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

/// Takes pictures of the scene while somebody asks. All from any thread.
class PictureSource
{
public:
    virtual ~PictureSource() = default;
    PictureSource() = default;
    PictureSource(const PictureSource&) = delete;
    PictureSource& operator=(const PictureSource&) = delete;

    /// Asks for pictures from now on for a while, and returns the newest; it may wait a moment for
    /// a first one.
    virtual MonitorPicture newest() = 0;
    virtual PictureCost cost() const = 0;
};

} // namespace midair::samples
