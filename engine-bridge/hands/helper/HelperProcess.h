#pragma once

#include <string>
#include <vector>

#include <sys/types.h>

namespace midair::bridge
{

/// A program that runs beside this one, with a socket between them that keeps the limits of
/// messages. It has of this program's files the standard output and error, and the socket, whose
/// number kSocket it gets; its end is seen at the socket by the other one.
class HelperProcess
{
public:
    static constexpr int kSocket = 3; ///< in the helper

    /// Starts the program in the file \a command[0]. Throws base::InputError.
    explicit HelperProcess(const std::vector<std::string>& command);
    /// Closes the socket; what doesn't end by that in \a kPatience_s is killed. Waits for its end.
    ~HelperProcess();
    HelperProcess(const HelperProcess&) = delete;
    HelperProcess& operator=(const HelperProcess&) = delete;

    int socket() const { return _socket; } ///< non-blocking
    pid_t process() const { return _process; }

    /// Ends it as the destructor does; returns how it ended: "was killed by signal 9".
    std::string end();

    static constexpr double kPatience_s = 1.0;

private:
    bool reap(int flags, std::string& how);

    int _socket = -1;
    pid_t _process = -1;
};

/// The program \a name that was built or installed beside this one or beside this library; empty
/// if there is none. PATH isn't asked: what stands there may be anybody's.
std::string programBeside(const std::string& name);

} // namespace midair::bridge
