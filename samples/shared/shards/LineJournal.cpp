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

constexpr std::size_t kMostBytes = std::size_t(1) << 30;

// The end of what line feeds close.
std::size_t wholeLines(const std::string& text)
{
    const std::size_t end = text.rfind('\n');
    return end == std::string::npos ? 0 : end + 1;
}

} // namespace

LineJournal::LineJournal(const std::string& path, std::string name, unsigned int mode) :
    _path(path),
    _name(std::move(name)),
    _mode(mode)
{
    try
    {
        _file = openLocked(path);
        _text = base::readRegularFile(path, kMostBytes, _name + " \"" + path + "\": ");
        if (_text.empty()) syncFolderOf(path);
    }
    catch (...)
    {
        if (_file >= 0) ::close(_file);
        throw;
    }
}

LineJournal::~LineJournal()
{
    ::fdatasync(_file);
    ::close(_file);
}

void LineJournal::fail(const std::string& path, const char* what) const
{
    throw base::InputError(fmt::format(
        "{} \"{}\" can't be {}: {}", _name, path, what, std::generic_category().message(errno)));
}

// What was opened may have been replaced before it was locked: then nobody would find what is
// written into it.
int LineJournal::openLocked(const std::string& path) const
{
    for (;;)
    {
        const int file = ::open(path.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, _mode);
        if (file < 0) fail(path, "opened");
        const bool isLocked = ::flock(file, LOCK_EX | LOCK_NB) == 0;
        struct stat locked = {};
        struct stat named = {};
        const bool isNamed = ::fstat(file, &locked) == 0 && ::stat(path.c_str(), &named) == 0 &&
                             locked.st_dev == named.st_dev && locked.st_ino == named.st_ino;
        if (isLocked && isNamed) return file;
        ::close(file);
        if (!isLocked)
            throw base::InputError(_name + " \"" + path + "\" are being written by another run");
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
    if (::ftruncate(_file, static_cast<off_t>(whole)) != 0) fail(_path, "shortened");
    _text.resize(whole);
}

void LineJournal::write(const std::string& path, const std::string& text)
{
    for (std::size_t done = 0; done < text.size();)
    {
        const ssize_t wrote = ::write(_file, text.data() + done, text.size() - done);
        if (wrote < 0 && errno == EINTR) continue;
        if (wrote < 0) fail(path, "written");
        done += static_cast<std::size_t>(wrote);
    }
}

void LineJournal::append(const std::string& text)
{
    write(_path, text);
}

void LineJournal::sync()
{
    if (::fdatasync(_file) != 0) fail(_path, "written");
}

void LineJournal::replace(const std::string& text)
{
    // Into a file beside it, which takes its place when it is whole; the old one is locked till
    // then.
    struct Locked
    {
        int file;
        ~Locked() { ::close(file); }
    };
    const std::string whole = _path + ".new";
    const Locked old{std::exchange(_file, openLocked(whole))};
    if (::ftruncate(_file, 0) != 0) fail(whole, "written");
    write(whole, text);
    if (::fdatasync(_file) != 0 || ::rename(whole.c_str(), _path.c_str()) != 0)
        fail(whole, "written");
    syncFolderOf(_path);
}

} // namespace midair::samples
