#include <cstdlib>
#include <cstring>

#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/un.h>
#include <unistd.h>

// An open device node is, under umockdev, a descriptor and a socket that carries its ioctls to the
// test. The child process that a board's last will is left to closes all descriptors but the
// node's, and the socket with them, which a node of the kernel's doesn't have. So this program
// brings a close_range of its own in place of libc's, which spares these sockets.

namespace
{

constexpr unsigned kMost = 1024; ///< descriptors that this program may have

bool carriesIoctls(int descriptor)
{
    const char* bed = ::getenv("UMOCKDEV_DIR");
    sockaddr_un peer{};
    socklen_t size = sizeof peer - 1;
    return bed != nullptr &&
           ::getpeername(descriptor, reinterpret_cast<sockaddr*>(&peer), &size) == 0 &&
           peer.sun_family == AF_UNIX && std::strncmp(peer.sun_path, bed, std::strlen(bed)) == 0 &&
           std::strstr(peer.sun_path, "/ioctl/") != nullptr;
}

} // namespace

extern "C" int close_range(unsigned first, unsigned last, int) noexcept
{
    for (unsigned i = first; i <= last && i < kMost; ++i)
        if (!carriesIoctls(static_cast<int>(i))) ::syscall(SYS_close, i);
    return 0;
}
