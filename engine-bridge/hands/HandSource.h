#pragma once

#include "engine-bridge/hands/Hand.h"

#include <cstddef>
#include <iosfwd>
#include <mutex>
#include <string>
#include <vector>

namespace midair::bridge
{

/// Where tracked hands come from: a tracker, a recording, the application or a mouse. Positions are
/// in metres in the world frame of the scene.
class HandSource
{
public:
    virtual ~HandSource() = default;

    /// The hands at \a time_s of the caller's clock; false, and no hands, where none is known.
    /// Never blocks. From one thread.
    virtual bool frameAt(double time_s, HandFrame& frame) = 0;

    /// One line that says what the source is and how it is doing.
    virtual std::string status() const = 0;
};

/// Plays a recording: the frame depends on the time asked for and on nothing else.
class RecordedHandSource : public HandSource
{
public:
    /// Between two frames less than this apart joints are interpolated; across a longer gap no hand
    /// is known.
    static constexpr double kLongestGap_s = 0.25;

    /// Throws base::InputError naming the file and the line.
    explicit RecordedHandSource(const std::string& path, bool loop = false);
    /// \a name stands in messages.
    RecordedHandSource(std::istream& in, const std::string& name, bool loop = false);

    bool frameAt(double time_s, HandFrame& frame) override;
    std::string status() const override;

    double duration_s() const; ///< time of the last frame; recordings begin at 0 or later
    const std::vector<HandFrame>& frames() const { return _frames; }

private:
    void read(std::istream& in);

    std::string _name;
    bool _loop;
    std::vector<HandFrame> _frames;
};

/// Writes frames as RecordedHandSource reads them: a line a joint with time_s, hand, joint, x, y,
/// z, qx, qy, qz, qw, radius_m, position_valid, orientation_valid.
void writeHandRecording(std::ostream& out, const std::vector<HandFrame>& frames);

/// Hands that the application sets; from any thread.
class InjectedHandSource : public HandSource
{
public:
    /// A frame older than \a staleAfter_s (> 0) counts as no hand.
    explicit InjectedHandSource(double staleAfter_s = 0.2) : _staleAfter_s(staleAfter_s) {}

    void set(const HandFrame& frame);
    void clear();

    bool frameAt(double time_s, HandFrame& frame) override;
    std::string status() const override;

private:
    double _staleAfter_s;
    mutable std::mutex _mutex;
    HandFrame _frame;
    std::size_t _set = 0;
};

} // namespace midair::bridge
