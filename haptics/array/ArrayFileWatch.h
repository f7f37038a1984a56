#pragma once

#include <cstdint>
#include <string>
#include <tuple>

namespace midair::haptics
{

/// Detects changes of an array's file by its state in the file system; it does not read the file.
/// For one thread.
class ArrayFileWatch
{
public:
    /// Shortest time between two checks of the file, s.
    static constexpr double kLook_s = 0.25;

    /// \a nameOrPath: as for TransducerArray::load(), which is called afterwards. Built-in arrays
    /// never change.
    explicit ArrayFileWatch(std::string nameOrPath);

    /// Returns true if the file differs from its state at the start (changed, replaced, deleted or
    /// created) and has not changed since the previous check, so that nobody is writing it now.
    /// Checks at most every kLook_s. \a now_s: steady clock.
    bool isChanged(double now_s);

    /// Returns true if the last check by isChanged() found the file different from the start.
    bool wasChanged() const { return _last != _read; }

private:
    /// Path, inode, size, and times of the last content and status changes, ns.
    using State = std::tuple<std::string, std::uint64_t, std::int64_t, std::int64_t, std::int64_t>;

    State look() const;

    std::string _nameOrPath;
    State _read;
    State _last;
    double _next_s = 0.0;
};

} // namespace midair::haptics
