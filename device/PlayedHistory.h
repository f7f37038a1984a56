#pragma once

#include <cstddef>
#include <deque>
#include <utility>
#include <vector>

namespace midair::device
{

/// What was played in the last moments: drives of any kind, each with the time from which it
/// sounded. Keeps what sounded within kKept_s of the newest, at most kMost drives.
template<typename Drive>
class PlayedHistory
{
public:
    static constexpr double kKept_s = 0.11;
    static constexpr std::size_t kMost = 1024; ///< 10,000 a second

    /// \a drive sounds from \a since_s on, which is not before the last.
    void note(double since_s, Drive drive)
    {
        _drives.emplace_back(since_s, std::move(drive));
        const bool isFull = _drives.size() > kMost;
        while (isFull ? _drives.size() > kMost
                      : _drives.size() > 1 && _drives[1].first <= since_s - kKept_s)
            _drives.pop_front();
    }
    const Drive* newest() const { return _drives.empty() ? nullptr : &_drives.back().second; }

    /// Returns the drives that sounded at \a from_s or later, in order; the first may have begun
    /// before.
    std::vector<std::pair<double, Drive>> since(double from_s) const
    {
        auto first = _drives.begin();
        while (first != _drives.end() && first + 1 != _drives.end() && (first + 1)->first <= from_s)
            ++first;
        return {first, _drives.end()};
    }

private:
    std::deque<std::pair<double, Drive>> _drives;
};

} // namespace midair::device
