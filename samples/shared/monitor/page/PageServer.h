#pragma once

#include "haptics/base/threads/Mutex.h"
#include "samples/shared/monitor/MonitorOptions.h"
#include "samples/shared/monitor/page/MonitorAddress.h"
#include "samples/shared/monitor/page/MonitorJson.h"
#include "samples/shared/monitor/page/PatientThreads.h"

#include <atomic>
#include <csignal>
#include <functional>
#include <list>
#include <memory>
#include <string>
#include <vector>

#include <httplib.h>

namespace midair::samples
{

/// Who the page is for.
struct PageAccess
{
    std::string token;              ///< that mutes and unmutes; not empty
    std::vector<std::string> hosts; ///< names for isTrustedHost()
};

/// The library's server makes the whole program ignore SIGPIPE, which is for the program to say.
struct PipeSignal
{
    PipeSignal() { ::sigaction(SIGPIPE, nullptr, &before); }
    struct sigaction before = {};
};

/// Answers HTTP requests, one a connection:
///
///     GET  /  /status.json  /metrics  /healthz  /picture  /favicon.ico
///     POST /mute  /unmute      with "Authorization: Bearer TOKEN"
///
/// Refused are: a Host that is not trusted (421), what another site's page sends (403; but
/// a link to / may be followed), a body (413), a POST without the token (401).
class PageServer : private PipeSignal,
                   private httplib::Server,
                   public std::enable_shared_from_this<PageServer>
{
public:
    /// \a picture may be null: there are no pictures.
    PageServer(std::string name,
               PageAccess access,
               std::shared_ptr<MonitorWatch> watch,
               std::shared_ptr<PictureSource> picture,
               const PageLimits& limits);
    ~PageServer() override;

    /// Serves on \a address from now on. Returns its port. Throws std::runtime_error: "can't listen
    /// on 127.0.0.1:8080: Address already in use".
    int listen(const MonitorAddress& address);
    /// Hangs up on all, and listens no more.
    void end();

    /// Answers what comes from \a socket, and closes it. Never throws.
    void serve(int socket);

private:
    class Queue;

    void serveAll();
    void take(std::function<void()> serving);
    bool process_and_close_socket(int socket) override;

    MonitorState state() const;
    void route(const httplib::Request& request, httplib::Response& response);
    void show(const std::string& path, httplib::Response& response) const;
    void showPicture(httplib::Response& response) const;
    void mute(const httplib::Request& request, httplib::Response& response) const;
    void act(bool isMute, const std::string& who, httplib::Response& response) const;

    const std::string _name;
    const PageAccess _access;
    const std::shared_ptr<MonitorWatch> _watch;
    const std::shared_ptr<PictureSource> _picture;
    const PageLimits _limits;
    const std::shared_ptr<std::atomic<int>> _mutes; ///< under way
    int _listener = -1;
    PatientThreads _threads; ///< each has a share of this server

    mutable base::Mutex _mutex;
    base::Condition _left;
    std::size_t _taken MIDAIR_GUARDED_BY(_mutex) = 0; ///< connections
    /// Of those being served; the first to be hung up on first.
    std::list<int> _sockets MIDAIR_GUARDED_BY(_mutex);
    bool _isEnded MIDAIR_GUARDED_BY(_mutex) = false;
    PageCounts _counts MIDAIR_GUARDED_BY(_mutex);
};

} // namespace midair::samples
