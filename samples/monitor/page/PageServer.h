#pragma once

#include "samples/monitor/page/MonitorJson.h"

#include <memory>
#include <string>
#include <vector>

namespace midair::samples
{

/// Who the page is for.
struct PageAccess
{
    std::string token;              ///< that mutes and unmutes; not empty
    std::vector<std::string> hosts; ///< names for isTrustedHost()
};

/// Answers single HTTP requests: texts in, texts out, without a socket. From any thread.
///
///     GET  /  /status.json  /metrics  /healthz  /picture  /favicon.ico
///     POST /mute  /unmute      with "Authorization: Bearer TOKEN"
///
/// Refused are: a Host that is not trusted (421), what another site's page sends (403; but
/// a link to / may be followed), a body (413), a POST without the token (401).
class PageServer
{
public:
    /// \a picture may be null: there are no pictures.
    PageServer(std::string name,
               PageAccess access,
               std::shared_ptr<MonitorWatch> watch,
               std::shared_ptr<PictureSource> picture);
    ~PageServer();
    PageServer(const PageServer&) = delete;
    PageServer& operator=(const PageServer&) = delete;

    /// \a head: a request up to its empty line. \a peer: numeric address of who asks. Returns the
    /// whole answer, after which the connection is to be closed; never throws.
    std::string answer(const std::string& head, const std::string& peer);

private:
    class Http;
    std::unique_ptr<Http> _http;
};

/// Returns who \a name, percent-encoded as a browser sends it, and \a peer are, in a line: "Anna
/// (192.168.1.7)". Of the name at most 40 bytes are taken, without control characters.
std::string operatorName(const std::string& name, const std::string& peer);

} // namespace midair::samples
