#pragma once

#include <cstdint>
#include <optional>
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

/// Handling of an existing recording in the file.
enum class Before
{
    REPLACED,    ///< replaced by a new one
    OVERWRITTEN, ///< likewise, whatever the file contains
    CONTINUED    ///< if this program was the last to record into it, otherwise replaced
};

/// Opens \a file for a recording, and locks it; empty, unless it is to be continued. Throws
/// DeviceError, and leaves the file as it is, if it exists and is neither a recording nor empty,
/// unless \a before is OVERWRITTEN. Also throws, whatever \a before is, if \a file is a link, is
/// not a regular file, has several hard links, can't be opened, or is being recorded or played.
/// Never waits.
OpenFile openForWriting(const std::string& file, Before before);

/// A recording ended by this program, with the data to continue it.
struct Ended
{
    int transducers = 0;
    std::uint64_t fields = 0;
    std::uint64_t bytes = 0; ///< of whole records, without the end mark
    double start_s = 0;      ///< base::steadySeconds()
};

/// Notes that the recording in the open file \a descriptor has ended. Any thread.
void noteEnd(int descriptor, const Ended& ended);
/// Returns the last note on that file, if it is unchanged since. Any thread.
std::optional<Ended> endOf(int descriptor);

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
