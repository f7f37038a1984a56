#pragma once

#include <string>

namespace midair::device::recording
{

/// Owns an open file; the destructor releases its lock and closes it.
class OpenFile
{
public:
    explicit OpenFile(int descriptor = -1) : _descriptor(descriptor) {}
    ~OpenFile();
    OpenFile(OpenFile&& other) noexcept;
    OpenFile& operator=(OpenFile&& other) noexcept;

    int descriptor() const { return _descriptor; }

private:
    int _descriptor;
};

/// Opens \a file, empty, for a new recording, and locks it. Throws DeviceError, and leaves the file
/// as it is, if it exists and is neither a recording nor empty, unless \a overwrite is set. Also
/// throws, whatever \a overwrite is, if \a file is a link, is not a regular file, has several hard
/// links, can't be opened, or is being recorded or played. Never waits.
OpenFile openForWriting(const std::string& file, bool overwrite);

/// A recording in memory. While it exists, its file is locked against new recordings.
class Show
{
public:
    /// Reads \a file. Throws DeviceError if it isn't a regular file, is larger than 2 GiB, can't be
    /// read, or isn't a recording for this number of transducers.
    Show(const std::string& file, int transducers);

    const std::string& file() const { return _file; }
    const std::string& bytes() const { return _bytes; }

private:
    std::string _file;
    OpenFile _held;
    std::string _bytes;
};

} // namespace midair::device::recording
