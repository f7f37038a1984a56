#pragma once

#include "samples/tools/sense/DesignerSession.h"

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace midair::samples
{

/// Options of a DesignerServer.
struct DesignerServerOptions
{
    int port = 8037;                  ///< AdapTics' own; 0: any free one
    std::vector<std::string> origins; ///< pages that may connect besides those of this machine
    std::size_t mostBytes = DesignerSession::kMostBytes; ///< of a message
};

/// Returns \a origin as browsers send it: "https://host", "http://host:8080" or "null" (a page from
/// a file). Throws InputError for anything else, as for a path behind the host.
std::string originFrom(const std::string& origin);

/// Returns true if a program whose Origin header is \a origin may connect: one without, pages of
/// localhost and 127.0.0.1 on any port, and those in \a allowed.
bool isAllowedOrigin(const std::string& origin, const std::vector<std::string>& allowed);

/// AdapTics' playback device on a port of this machine, ws://127.0.0.1:PORT/. Pages of other sites
/// get HTTP 403. One client plays at a time, others are closed with a reason. When it disconnects
/// or no longer answers, the output falls silent.
class DesignerServer
{
public:
    /// Begins to listen. \a tell receives sentences for the user, on run()'s thread. Throws
    /// InputError if the port can't be had.
    DesignerServer(SenseOutput& output,
                   const DesignerServerOptions& options,
                   std::function<void(const std::string&)> tell);
    ~DesignerServer();
    DesignerServer(const DesignerServer&) = delete;
    DesignerServer& operator=(const DesignerServer&) = delete;

    int port() const;
    /// Serves until stop(), and updates the output 60 times a second. All calls of the output are
    /// on this thread. \a isStopAsked, if any, is looked at as often.
    void run(const std::function<bool()>& isStopAsked = {});
    /// Silences the output and ends run(). Any thread.
    void stop();

private:
    class Endpoint;
    std::unique_ptr<Endpoint> _endpoint;
};

} // namespace midair::samples
