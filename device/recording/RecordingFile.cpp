#include "device/recording/RecordingFile.h"

#include "device/ArrayDevice.h"
#include "device/recording/Recording.h"
#include "haptics/base/RegularFile.h"
#include "haptics/base/threads/Mutex.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <deque>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

namespace midair::device::recording
{

namespace
{

constexpr std::size_t kMostBytes = std::size_t(2) << 30;
// Doesn't follow a link as the last part of the path, doesn't wait for the other end of a pipe, and
// doesn't make a terminal the controlling one.
constexpr int kCareful = O_NOFOLLOW | O_NONBLOCK | O_NOCTTY | O_CLOEXEC;

constexpr std::size_t kMostEnds = 256;

struct NotedEnd
{
    dev_t device;
    ino_t inode;
    off_t size;
    Ended ended;

    bool isOf(const struct stat& about) const
    {
        return about.st_dev == device && about.st_ino == inode;
    }
};

struct Ends
{
    base::Mutex mutex;
    std::deque<NotedEnd> noted MIDAIR_GUARDED_BY(mutex); ///< the oldest first
};

// Never destroyed: devices may be closed while the program ends.
Ends& ends()
{
    static auto* const all = new Ends;
    return *all;
}

[[noreturn]] void fail(const std::string& file, const std::string& why)
{
    throw DeviceError("recording \"" + file + "\": " + why);
}

[[noreturn]] void failToWrite(const std::string& file)
{
    fail(file, "can't be written: " + std::generic_category().message(errno));
}

// Called before the file is opened, because opening some devices has side effects, and again after.
void requireOwnFile(const std::string& file, const struct stat& about)
{
    if (S_ISLNK(about.st_mode)) fail(file, "is a link; name the file itself");
    if (S_ISDIR(about.st_mode)) fail(file, "is a folder; name a file in it");
    if (!S_ISREG(about.st_mode))
        fail(file, "is a device or a pipe; a recording goes into a regular file");
    if (about.st_nlink > 1)
        fail(file,
             fmt::format("has {} names (hard links), and a recording would change all of them; "
                         "choose another name",
                         about.st_nlink));
}

void requireRecording(const std::string& file, int descriptor)
{
    std::array<char, kMagicBytes> begin{};
    const ssize_t count = ::pread(descriptor, begin.data(), begin.size(), 0);
    if (count < 0) failToWrite(file);
    if (count == 0 || (count == static_cast<ssize_t>(begin.size()) &&
                       std::memcmp(begin.data(), kMagic, begin.size()) == 0))
        return;
    fail(file,
         "exists and isn't a recording (it doesn't start with MIDAIRF); choose another name, or "
         "use record:" +
             file + "?overwrite=yes");
}

} // namespace

void noteEnd(int descriptor, const Ended& ended)
{
    struct stat about = {};
    if (::fstat(descriptor, &about) != 0) return;
    Ends& known = ends();
    const base::Lock lock(known.mutex);
    std::deque<NotedEnd>& all = known.noted;
    all.erase(std::remove_if(
                  all.begin(), all.end(), [&](const NotedEnd& one) { return one.isOf(about); }),
              all.end());
    all.push_back({about.st_dev, about.st_ino, about.st_size, ended});
    if (all.size() > kMostEnds) all.pop_front();
}

std::optional<Ended> endOf(int descriptor)
{
    struct stat about = {};
    if (::fstat(descriptor, &about) != 0) return {};
    Ends& known = ends();
    const base::Lock lock(known.mutex);
    for (const NotedEnd& one : known.noted)
        if (one.isOf(about) && one.size == about.st_size) return one.ended;
    return {};
}

OpenFile::~OpenFile()
{
    if (_descriptor < 0) return;
    ::flock(_descriptor, LOCK_UN); // close() isn't enough if a child process also has the
                                   // descriptor
    ::close(_descriptor);
}

OpenFile::OpenFile(OpenFile&& other) noexcept : _descriptor(std::exchange(other._descriptor, -1)) {}

OpenFile& OpenFile::operator=(OpenFile&& other) noexcept
{
    std::swap(_descriptor, other._descriptor);
    return *this;
}

OpenFile openForWriting(const std::string& file, Before before)
{
    struct stat about = {};
    const bool there = ::lstat(file.c_str(), &about) == 0;
    if (!there && errno != ENOENT) failToWrite(file);
    if (there) requireOwnFile(file, about);
    OpenFile opened(::open(file.c_str(), (there ? O_RDWR : O_RDWR | O_CREAT) | kCareful, 0666));
    const int descriptor = opened.descriptor();
    if (descriptor < 0 && errno == ELOOP) fail(file, "is a link; name the file itself");
    if (descriptor < 0 || ::fstat(descriptor, &about) != 0) failToWrite(file);
    requireOwnFile(file, about);
    // Ignores other errors, as on a file system without locks: two users of one file are then not
    // kept apart.
    if (::flock(descriptor, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK)
        fail(file, "is being recorded or played by somebody else; choose another name");
    if (before != Before::OVERWRITTEN) requireRecording(file, descriptor);
    if (before == Before::CONTINUED && endOf(descriptor)) return opened;
    if (::ftruncate(descriptor, 0) != 0) failToWrite(file);
    return opened;
}

Show::Show(const std::string& file, int transducers) : _file(file)
{
    try
    {
        // A shared lock, which blocks openForWriting(); without it the recording is played all the
        // same.
        struct stat about = {};
        if (::stat(file.c_str(), &about) == 0 && S_ISREG(about.st_mode))
            _held = OpenFile(::open(file.c_str(), O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC));
        if (_held.descriptor() >= 0) ::flock(_held.descriptor(), LOCK_SH | LOCK_NB);
        _bytes = base::readRegularFile(file, kMostBytes);
    }
    catch (const base::FileError& error)
    {
        fail(file, error.what());
    }
    const Reader reader(_bytes, file);
    if (reader.transducers() != transducers)
        fail(file,
             fmt::format("was made for {} transducers, but the array has {}",
                         reader.transducers(),
                         transducers));
}

} // namespace midair::device::recording
