#pragma once

#include "device/recording/RecordingFile.h"

#include <cstddef>
#include <filesystem>
#include <string>

#include <fcntl.h>
#include <unistd.h>

namespace midair::samples
{

/// Makes the file \a path survive a power failure by syncing its folder, if the file system can.
inline void syncFolderOf(const std::string& path)
{
    const std::string folder = std::filesystem::path(path).parent_path().string();
    const int file =
        ::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (file < 0) return;
    ::fsync(file);
    ::close(file);
}

/// Writes all of \a bytes. Returns false and sets errno on failure.
bool writeAll(int file, const void* bytes, std::size_t count);

/// A text file written line by line; the next run can continue it, however this one ends. Only one
/// process can open it at a time.
class LineJournal
{
public:
    /// Opens \a path, or creates it with \a mode. \a name is its content in messages ("readings").
    /// Throws base::InputError if another process has it, or if it can't be read or written.
    LineJournal(const std::string& path, std::string name, unsigned int mode = 0644);
    ~LineJournal();
    LineJournal(const LineJournal&) = delete;
    LineJournal& operator=(const LineJournal&) = delete;

    /// Returns the content when it was opened, including a torn line.
    const std::string& text() const { return _text; }
    /// Returns the rest of text() after the last line feed: an incomplete line after a power
    /// failure.
    std::string tornLine() const;
    /// Removes the torn line from the file.
    void cutTornLine();

    /// Appends \a text, which survives a kill at once. Throws base::InputError.
    void append(const std::string& text);
    /// Waits until everything is on disk and survives a power failure. Throws base::InputError.
    void sync();
    /// Replaces all lines by \a text atomically; the file stays open. Throws base::InputError.
    void replace(const std::string& text);

private:
    [[noreturn]] void fail(const std::string& path, const char* what) const;
    device::recording::OpenFile openLocked(const std::string& path) const;
    void write(const std::string& path, const std::string& text);

    const std::string _path;
    const std::string _name;
    const unsigned int _mode;
    device::recording::OpenFile _file;
    std::string _text;
};

} // namespace midair::samples
