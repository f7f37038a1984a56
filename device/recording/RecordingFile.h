#pragma once

#include <string>

namespace midair::device::recording
{

/// An open file that is closed at the end, and its lock with it.
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

/// Opens \a file, empty, for a new recording. What is there already stays as it is, and DeviceError
/// says why, unless it is a recording or empty, or \a overwrite is set; in no case is anything
/// written that isn't a regular file of one name, or through a link, or into what somebody else
/// records or plays at the time. Never waits.
OpenFile openForWriting(const std::string& file, bool overwrite);

/// A recording in memory. Nobody records over its file as long as this lives.
class Show
{
public:
    /// Throws DeviceError for a file that isn't regular, is larger than 2 GiB, can't be read, or
    /// isn't a recording for so many transducers.
    Show(const std::string& file, int transducers);

    const std::string& file() const { return _file; }
    const std::string& bytes() const { return _bytes; }

private:
    std::string _file;
    OpenFile _held;
    std::string _bytes;
};

} // namespace midair::device::recording
