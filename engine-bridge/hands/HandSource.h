#pragma once

#include "engine-bridge/hands/Hand.h"
#include "haptics/base/threads/Mutex.h"

#include <cstddef>
#include <iosfwd>
#include <string>
#include <vector>

namespace midair::bridge
{

struct RecordedRow;

/// A source of tracked hands: a tracker, a recording, the application or a mouse. Positions are in
/// metres in the world frame of the scene.
class HandSource
{
public:
    virtual ~HandSource() = default;

    /// Stores the hands at \a time_s of the caller's clock in \a frame. Returns false, and no
    /// hands, if none are known. Never blocks. To be called from one thread.
    virtual bool frameAt(double time_s, HandFrame& frame) = 0;

    /// Requests the hands \a ahead_s (>= 0) after the time of frameAt() from now on; 0 ends that.
    /// Returns false and changes nothing if the source can't predict.
    virtual bool setHorizon(double /*ahead_s*/) { return false; }

    /// Stores the hands at the display time of the present frame in \a frame. Returns false if the
    /// source doesn't know that time: those of frameAt() are shown.
    virtual bool shownFrame(HandFrame& /*frame*/) { return false; }

    /// One line of text: the source and its state.
    virtual std::string status() const = 0;

    /// Messages for the user since the last call; each is returned once.
    virtual std::vector<std::string> takeMessages() { return {}; }
};

/// Plays a recording: the frame depends only on the requested time. RecordedHeadSource plays its
/// heads.
class RecordedHandSource : public HandSource
{
public:
    /// Joints are interpolated between two frames at most this far apart; in a longer gap there are
    /// no hands.
    static constexpr double kLongestGap_s = 0.25;

    /// Throws base::InputError, which names the file and the line. \a loop: the recording repeats
    /// after duration_s(); otherwise there are no hands after it.
    explicit RecordedHandSource(const std::string& path, bool loop = false);
    /// \a name appears in messages.
    RecordedHandSource(std::istream& in, const std::string& name, bool loop = false);

    bool frameAt(double time_s, HandFrame& frame) override;
    std::string status() const override;

    double duration_s() const; ///< time of the last frame; recordings begin at 0 or later
    const std::vector<HandFrame>& frames() const { return _frames; }

private:
    void read(std::istream& in);
    std::string take(const RecordedRow& row, std::size_t& hands);

    std::string _name;
    bool _loop;
    std::vector<HandFrame> _frames;
};

/// Hands set by the application; all members may be called from any thread.
class InjectedHandSource : public HandSource
{
public:
    /// A frame whose time differs by more than \a staleAfter_s (> 0) from the requested time counts
    /// as no hands.
    explicit InjectedHandSource(double staleAfter_s = 0.2) : _staleAfter_s(staleAfter_s) {}

    void set(const HandFrame& frame);
    void clear();

    bool frameAt(double time_s, HandFrame& frame) override;
    std::string status() const override;

private:
    double _staleAfter_s;
    mutable base::Mutex _mutex;
    HandFrame _frame MIDAIR_GUARDED_BY(_mutex);
    std::size_t _set MIDAIR_GUARDED_BY(_mutex) = 0;
};

} // namespace midair::bridge
