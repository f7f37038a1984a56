#include "samples/shared/shards/LineJournal.h"

#include "haptics/base/InputError.h"
#include "haptics/base/RegularFile.h"

#include <cerrno>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>

namespace midair::samples
{

namespace
{

using device::recording::OpenFile;

constexpr std::size_t kMostBytes = std::size_t(1) << 30;

// Returns the length of the text up to its last line feed.
std::size_t wholeLines(const std::string& text)
{
    const std::size_t end = text.rfind('\n');
    return end == std::string::npos ? 0 : end + 1;
}

} // namespace

bool writeAll(int file, const void* bytes, std::size_t count)
{
    const char* const text = static_cast<const char*>(bytes);
    for (std::size_t done = 0; done < count;)
    {
        const ssize_t wrote = ::write(file, text + done, count - done);
        if (wrote < 0 && errno == EINTR) continue;
        if (wrote <= 0) return false;
        done += static_cast<std::size_t>(wrote);
    }
    return true;
}

LineJournal::LineJournal(const std::string& path, std::string name, unsigned int mode) :
    _path(path),
    _name(std::move(name)),
    _mode(mode),
    _file(openLocked(path)),
    _text(base::readRegularFile(path, kMostBytes, _name + " \"" + path + "\": "))
{
    if (_text.empty()) syncFolderOf(path);
}

LineJournal::~LineJournal()
{
    ::fdatasync(_file.descriptor());
}

void LineJournal::fail(const std::string& path, const char* what) const
{
    throw base::InputError(fmt::format(
        "{} \"{}\" can't be {}: {}", _name, path, what, std::generic_category().message(errno)));
}

// The file may have been replaced before it was locked; writes into the old one would be lost.
OpenFile LineJournal::openLocked(const std::string& path) const
{
    for (;;)
    {
        OpenFile opened(::open(path.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, _mode));
        const int file = opened.descriptor();
        if (file < 0) fail(path, "opened");
        if (::flock(file, LOCK_EX | LOCK_NB) != 0)
            throw base::InputError(_name + " \"" + path + "\" are being written by another run");
        struct stat locked = {};
        struct stat named = {};
        if (::fstat(file, &locked) == 0 && ::stat(path.c_str(), &named) == 0 &&
            locked.st_dev == named.st_dev && locked.st_ino == named.st_ino)
            return opened;
    }
}

std::string LineJournal::tornLine() const
{
    return _text.substr(wholeLines(_text));
}

void LineJournal::cutTornLine()
{
    const std::size_t whole = wholeLines(_text);
    if (whole == _text.size()) return;
    if (::ftruncate(_file.descriptor(), static_cast<off_t>(whole)) != 0) fail(_path, "shortened");
    _text.resize(whole);
}

void LineJournal::write(const std::string& path, const std::string& text)
{
    if (!writeAll(_file.descriptor(), text.data(), text.size())) fail(path, "written");
}

void LineJournal::append(const std::string& text)
{
    write(_path, text);
}

void LineJournal::sync()
{
    if (::fdatasync(_file.descriptor()) != 0) fail(_path, "written");
}

void LineJournal::replace(const std::string& text)
{
    // Writes a file beside it and renames it; the old one stays locked until then.
    const std::string whole = _path + ".new";
    const OpenFile old = std::exchange(_file, openLocked(whole));
    if (::ftruncate(_file.descriptor(), 0) != 0) fail(whole, "written");
    write(whole, text);
    if (::fdatasync(_file.descriptor()) != 0 || ::rename(whole.c_str(), _path.c_str()) != 0)
        fail(whole, "written");
    syncFolderOf(_path);
}

} // namespace midair::samples
