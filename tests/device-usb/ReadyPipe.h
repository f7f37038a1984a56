#pragma once

#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <string>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

/// A named pipe in place of a device node: poll() finds it ready to be written to when we say so,
/// and not before.
class ReadyPipe
{
public:
    ReadyPipe() = default;
    ~ReadyPipe() { close(); }
    ReadyPipe(const ReadyPipe&) = delete;
    ReadyPipe& operator=(const ReadyPipe&) = delete;

    /// Takes the place of the file at \a path; not ready.
    void make(const std::string& path)
    {
        close();
        ::unlink(path.c_str());
        const bool made = ::mkfifo(path.c_str(), 0666) == 0;
        _end = made ? ::open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC) : -1;
        if (_end < 0 || ::fcntl(_end, F_SETPIPE_SZ, 4096) < 0)
            throw std::runtime_error(path + ": " + std::strerror(errno));
        _ready = true;
        set(false);
    }

    /// A pipe of one page takes no more once there is a byte in it.
    void set(bool ready)
    {
        if (ready == _ready || _end < 0) return;
        char byte = 0;
        const ssize_t moved = ready ? ::read(_end, &byte, 1) : ::write(_end, &byte, 1);
        if (moved == 1) _ready = ready;
    }

private:
    void close()
    {
        if (_end >= 0) ::close(_end);
        _end = -1;
    }

    int _end = -1;
    bool _ready = false;
};
