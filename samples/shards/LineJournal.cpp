#include "samples/shards/LineJournal.h"

#include "haptics/base/InputError.h"
#include "haptics/base/RegularFile.h"

#include <cerrno>
#include <filesystem>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

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

// Makes the name of a new file outlive a power failure, as far as the file system can.
void syncFolderOf(const std::string& path)
{
    const std::string folder = std::filesystem::path(path).parent_path().string();
    const int file =
        ::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (file < 0) return;
    ::fsync(file);
    ::close(file);
}

} // namespace

LineJournal::LineJournal(const std::string& path, std::string name, unsigned int mode) :
    _path(path),
    _name(std::move(name)),
    _mode(mode)
{
    try
    {
        openLocked(path, 0);
        _text = base::readRegularFile(path, kMostBytes);
        if (_text.empty()) syncFolderOf(path);
    }
    catch (const base::FileError& error)
    {
        ::close(_file);
        throw base::InputError(_name + " \"" + path + "\": " + error.what());
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

void LineJournal::openLocked(const std::string& path, int flags)
{
    const int file = ::open(path.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC | flags, _mode);
    if (file < 0) fail(path, "opened");
    if (_file >= 0) ::close(_file);
    _file = file;
    if (::flock(_file, LOCK_EX | LOCK_NB) != 0)
        throw base::InputError(_name + " \"" + path + "\" are being written by another run");
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
    // Into a file beside it, which takes its place when it is whole.
    const std::string whole = _path + ".new";
    openLocked(whole, O_TRUNC);
    write(whole, text);
    if (::fdatasync(_file) != 0 || ::rename(whole.c_str(), _path.c_str()) != 0)
        fail(whole, "written");
    syncFolderOf(_path);
}

} // namespace midair::samples
