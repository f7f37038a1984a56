#include "samples/installations/shell/SaidLines.h"

#include <algorithm>
#include <cstdio>

namespace midair::samples
{

namespace
{

/// Lines that differ in numbers alone say the same.
std::string withoutNumbers(std::string text)
{
    const auto isOfNumber = [](char c) { return (c >= '0' && c <= '9') || c == '.' || c == '\n'; };
    text.erase(std::remove_if(text.begin(), text.end(), isOfNumber), text.end());
    return text;
}

} // namespace

void SaidLines::notify(osg::NotifySeverity severity, const char* message)
{
    std::fputs(message, severity <= osg::WARN ? stderr : stdout);
    const std::lock_guard<std::mutex> lock(_mutex);
    ++_count;
    const auto now = std::chrono::steady_clock::now();
    if (now - _begin >= std::chrono::seconds(1))
    {
        _begin = now;
        _second.clear();
    }
    const std::string what = withoutNumbers(message);
    if (what.empty()) return; // an end of a line
    const std::uint64_t times = ++_second[what];
    if (times > 1) _tooOften[what] = std::max(_tooOften[what], times);
}

std::uint64_t SaidLines::count() const
{
    const std::lock_guard<std::mutex> lock(_mutex);
    return _count;
}

std::map<std::string, std::uint64_t> SaidLines::tooOften() const
{
    const std::lock_guard<std::mutex> lock(_mutex);
    return _tooOften;
}

} // namespace midair::samples
