#pragma once

#include <string>
#include <vector>

#include <sys/types.h>

namespace midair::bridge
{

/// A helper program, connected by a socket that preserves message boundaries. It inherits only
/// standard output, standard error and the socket, as file descriptor kSocket; each side sees the
/// other's end at the socket.
class HelperProcess
{
public:
    static constexpr int kSocket = 3; ///< number in the helper

    /// Starts the program \a command[0]. Throws base::InputError.
    explicit HelperProcess(const std::vector<std::string>& command);
    /// Closes the socket; kills the helper if it doesn't end within \a kPatience_s. Waits for its
    /// end.
    ~HelperProcess();
    HelperProcess(const HelperProcess&) = delete;
    HelperProcess& operator=(const HelperProcess&) = delete;

    int socket() const { return _socket; } ///< non-blocking
    pid_t process() const { return _process; }

    /// Ends it like the destructor; returns how it ended: "was killed by signal 9".
    std::string end();

    static constexpr double kPatience_s = 1.0;

private:
    bool reap(int flags, std::string& how);

    int _socket = -1;
    pid_t _process = -1;
};

/// Returns the path of the program \a name built or installed beside this one or beside this
/// library; empty if there is none. Ignores PATH, which anybody may have set.
std::string programBeside(const std::string& name);

} // namespace midair::bridge
