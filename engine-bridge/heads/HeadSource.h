#pragma once

#include "engine-bridge/hands/Head.h"
#include "haptics/base/threads/Mutex.h"

#include <Eigen/Geometry>

#include <cstddef>
#include <iosfwd>
#include <string>
#include <vector>

namespace midair::bridge
{

/// A source of one viewer's head: a tracker, a recording, the application or a mouse.
class HeadSource
{
public:
    virtual ~HeadSource() = default;

    /// Puts the head at \a time_s of the caller's clock into \a head. Returns its isTracked. Never
    /// blocks. To be called from one thread.
    virtual bool headAt(double time_s, Head& head) = 0;

    /// Asks for the head as it will be \a ahead_s (>= 0) after the time of headAt(), from now on; 0
    /// ends that. Returns false, and changes nothing, if the source can't tell.
    virtual bool setHorizon(double /*ahead_s*/) { return false; }

    /// One line of text: what the source is, and its state.
    virtual std::string status() const = 0;

    /// What the user should know that has happened since the last call; each one is told once.
    virtual std::vector<std::string> takeMessages() { return {}; }
};

/// A head that never moves: a seat, or a hole that one looks through.
class FixedHeadSource : public HeadSource
{
public:
    explicit FixedHeadSource(const Eigen::Isometry3d& pose) : _pose(pose) {}

    /// An upright head at \a place (metres) that looks at the world's origin, z up; straight above
    /// or below it y is up.
    static Eigen::Isometry3d upright(const Eigen::Vector3d& place);

    bool headAt(double time_s, Head& head) override;
    /// At any time it is where it is.
    bool setHorizon(double /*ahead_s*/) override { return true; }
    std::string status() const override;

private:
    const Eigen::Isometry3d _pose;
};

/// Plays the heads of a recording, which may hold hands as well (their source is
/// RecordedHandSource): lines whose joint is "head". The head depends only on the time asked for.
class RecordedHeadSource : public HeadSource
{
public:
    /// A head is interpolated between two that are at most this far apart; in a longer gap there
    /// is none.
    static constexpr double kLongestGap_s = 0.25;

    /// Throws base::InputError, which names the file and the line. \a loop: the recording repeats
    /// after its last head; else there is none after it.
    explicit RecordedHeadSource(const std::string& path, bool loop = false);
    /// \a name appears in messages.
    RecordedHeadSource(std::istream& in, const std::string& name, bool loop = false);

    bool headAt(double time_s, Head& head) override;
    std::string status() const override;

    const std::vector<Head>& heads() const { return _heads; } ///< in the order of their times

private:
    void read(std::istream& in);

    std::string _name;
    bool _loop;
    std::vector<Head> _heads;
};

/// A head that the application sets; all members may be called from any thread.
class InjectedHeadSource : public HeadSource
{
public:
    /// A head whose time differs by more than \a staleAfter_s (> 0) from the time asked for counts
    /// as none.
    explicit InjectedHeadSource(double staleAfter_s = 0.2) : _staleAfter_s(staleAfter_s) {}

    void set(const Head& head);
    void clear() { set({}); }

    bool headAt(double time_s, Head& head) override;
    std::string status() const override;

private:
    double _staleAfter_s;
    mutable base::Mutex _mutex;
    Head _head MIDAIR_GUARDED_BY(_mutex);
    std::size_t _set MIDAIR_GUARDED_BY(_mutex) = 0;
};

} // namespace midair::bridge
