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

    /// Stores the head at \a time_s of the caller's clock in \a head. Returns its isTracked. Never
    /// blocks. To be called from one thread.
    virtual bool headAt(double time_s, Head& head) = 0;

    /// Requests the head \a ahead_s (>= 0) after the time of headAt() from now on; 0 ends that.
    /// Returns false and changes nothing if the source can't predict.
    virtual bool setHorizon(double /*ahead_s*/) { return false; }

    /// One line of text: the source and its state.
    virtual std::string status() const = 0;

    /// Messages for the user since the last call; each is returned once.
    virtual std::vector<std::string> takeMessages() { return {}; }
};

/// A head that never moves: a seat, or a peephole.
class FixedHeadSource : public HeadSource
{
public:
    explicit FixedHeadSource(const Eigen::Isometry3d& pose) : _pose(pose) {}

    /// An upright head at \a place (metres) that looks at the world's origin, z up; directly above
    /// or below it, y up.
    static Eigen::Isometry3d upright(const Eigen::Vector3d& place);

    bool headAt(double time_s, Head& head) override;
    /// It is at the same place at any time.
    bool setHorizon(double /*ahead_s*/) override { return true; }
    std::string status() const override;

private:
    const Eigen::Isometry3d _pose;
};

/// Plays the heads of a recording, which may also contain hands (see RecordedHandSource): lines
/// with the joint "head". The head depends only on the requested time.
class RecordedHeadSource : public HeadSource
{
public:
    /// Heads are interpolated between two that are at most this far apart; in a longer gap there is
    /// none.
    static constexpr double kLongestGap_s = 0.25;

    /// Throws base::InputError, which names the file and the line. \a loop: the recording repeats
    /// after its last head; otherwise there is none after it.
    explicit RecordedHeadSource(const std::string& path, bool loop = false);
    /// \a name appears in messages.
    RecordedHeadSource(std::istream& in, const std::string& name, bool loop = false);

    bool headAt(double time_s, Head& head) override;
    std::string status() const override;

    const std::vector<Head>& heads() const { return _heads; } ///< ordered by time

private:
    void read(std::istream& in);

    std::string _name;
    bool _loop;
    std::vector<Head> _heads;
};

/// A head set by the application; all members may be called from any thread.
class InjectedHeadSource : public HeadSource
{
public:
    /// A head whose time differs by more than \a staleAfter_s (> 0) from the requested time counts
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
