#pragma once

#include <cstdint>
#include <string>
#include <tuple>

namespace midair::haptics
{

/// Tells when the file of an array has changed, by what the file system knows of it; the file isn't
/// read. For one thread.
class ArrayFileWatch
{
public:
    /// Shortest time between two looks at the file, s.
    static constexpr double kLook_s = 0.25;

    /// \a nameOrPath: as for TransducerArray::load(), which is to be called afterwards. What is
    /// built in never changes.
    explicit ArrayFileWatch(std::string nameOrPath);

    /// Returns true if the file is another than at the start (changed, replaced, gone or there at
    /// last) and was the same at the look before, so that nobody writes it right now. Looks at
    /// most every kLook_s. \a now_s: steady clock.
    bool isChanged(double now_s);

    /// Returns true if the file was another than at the start when isChanged() looked last.
    bool wasChanged() const { return _last != _read; }

private:
    /// Path, inode, size, and the times of the last changes of content and of state, ns.
    using State = std::tuple<std::string, std::uint64_t, std::int64_t, std::int64_t, std::int64_t>;

    State look() const;

    std::string _nameOrPath;
    State _read;
    State _last;
    double _next_s = 0.0;
};

} // namespace midair::haptics
