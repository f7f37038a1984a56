#pragma once

#include "device/recording/RecordingFile.h"

#include <cstddef>
#include <filesystem>
#include <string>

#include <fcntl.h>
#include <unistd.h>

namespace midair::samples
{

/// Makes the new name of the file \a path outlive a power failure, as far as the file system can.
inline void syncFolderOf(const std::string& path)
{
    const std::string folder = std::filesystem::path(path).parent_path().string();
    const int file =
        ::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (file < 0) return;
    ::fsync(file);
    ::close(file);
}

/// Writes all of \a bytes into an open file. Returns false, with errno, if it can't be done.
bool writeAll(int file, const void* bytes, std::size_t count);

/// A text file that is written line by line while something goes on, and gone on with by the next
/// run when this one ends, however it ends. One process has it at a time.
class LineJournal
{
public:
    /// Opens \a path, or makes it, with \a mode. \a name: what it holds, for messages ("readings").
    /// Throws base::InputError if another process has it, or if it can't be read or written.
    LineJournal(const std::string& path, std::string name, unsigned int mode = 0644);
    ~LineJournal();
    LineJournal(const LineJournal&) = delete;
    LineJournal& operator=(const LineJournal&) = delete;

    /// What was there when it was opened, the torn line included.
    const std::string& text() const { return _text; }
    /// Returns the end of text() that no line feed closes: what a power failure left of a line.
    std::string tornLine() const;
    /// Takes the torn line out of the file.
    void cutTornLine();

    /// Appends \a text. It survives a kill at once. Throws base::InputError.
    void append(const std::string& text);
    /// Waits until all is on the disk, so that it survives a power failure. Throws
    /// base::InputError.
    void sync();
    /// Puts \a text in place of all lines, at once, and stays open. Throws base::InputError.
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
