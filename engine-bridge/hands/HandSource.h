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

    /// Puts the hands at \a time_s of the caller's clock into \a frame. Returns false, and no
    /// hands, if none are known. Never blocks. To be called from one thread.
    virtual bool frameAt(double time_s, HandFrame& frame) = 0;

    /// Asks for hands as they will be \a ahead_s (>= 0) after the time of frameAt(), from now on; 0
    /// ends that. Returns false, and changes nothing, if the source can't tell.
    virtual bool setHorizon(double /*ahead_s*/) { return false; }

    /// One line of text: what the source is, and its state.
    virtual std::string status() const = 0;

    /// What the user should know that has happened since the last call; each one is told once.
    virtual std::vector<std::string> takeMessages() { return {}; }
};

/// Plays a recording: the frame depends only on the time asked for. The heads in it are another
/// source's.
class RecordedHandSource : public HandSource
{
public:
    /// Joints are interpolated between two frames at most this far apart; in a longer gap there are
    /// no hands.
    static constexpr double kLongestGap_s = 0.25;

    /// Throws base::InputError, which names the file and the line. \a loop: the recording repeats
    /// after duration_s(); else there are no hands after it.
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

/// Hands that the application sets; all members may be called from any thread.
class InjectedHandSource : public HandSource
{
public:
    /// A frame whose time differs by more than \a staleAfter_s (> 0) from the time asked for counts
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
