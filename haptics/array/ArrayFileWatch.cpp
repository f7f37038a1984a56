#include "haptics/array/ArrayFileWatch.h"

#include "haptics/array/TransducerArray.h"

#include <utility>

#include <sys/stat.h>

namespace midair::haptics
{

namespace
{

std::int64_t nanoseconds(const struct timespec& time)
{
    return std::int64_t(time.tv_sec) * 1'000'000'000 + time.tv_nsec;
}

} // namespace

ArrayFileWatch::ArrayFileWatch(std::string nameOrPath) :
    _nameOrPath(std::move(nameOrPath)),
    _read(look()),
    _last(_read)
{
}

ArrayFileWatch::State ArrayFileWatch::look() const
{
    const std::string path = TransducerArray::fileOf(_nameOrPath);
    struct stat about = {};
    if (path.empty() || ::stat(path.c_str(), &about) != 0) return {};
    // The status time changes even if a tool preserves the content time.
    return {
        path, about.st_ino, about.st_size, nanoseconds(about.st_mtim), nanoseconds(about.st_ctim)};
}

bool ArrayFileWatch::isChanged(double now_s)
{
    if (now_s < _next_s || _nameOrPath.empty()) return false;
    _next_s = now_s + kLook_s;
    State now = look();
    const bool rests = now == _last;
    _last = std::move(now);
    return rests && _last != _read;
}

} // namespace midair::haptics
