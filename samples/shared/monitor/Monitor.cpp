#include "samples/shared/monitor/Monitor.h"

#include "samples/shared/monitor/page/MonitorToken.h"
#include "samples/shared/monitor/page/MonitorWatch.h"
#include "samples/shared/monitor/page/PageServer.h"

#include <cstdio>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

namespace midair::samples
{

Monitor::Monitor(const MonitorOptions& options,
                 const std::string& name,
                 std::shared_ptr<MonitorSource> source,
                 std::shared_ptr<PictureSource> picture,
                 const PageLimits& limits)
{
    try
    {
        _address = MonitorAddress::parse(options.address);
    }
    catch (const std::exception& error)
    {
        throw std::runtime_error(std::string("--monitor: ") + error.what());
    }
    _token = options.tokenFile.empty() ? newToken() : tokenOfFile(options.tokenFile);
    PageAccess access{_token, ownHostNames()};
    access.hosts.insert(access.hosts.end(), options.hosts.begin(), options.hosts.end());
    _page = std::make_shared<PageServer>(name,
                                         std::move(access),
                                         std::make_shared<MonitorWatch>(std::move(source)),
                                         std::move(picture),
                                         limits);
    _address.port = _page->listen(_address);
    const std::string secret =
        options.tokenFile.empty()
            ? fmt::format("{}#token={}", url(), _token)
            : fmt::format("{} (its token is in {})", url(), options.tokenFile);
    std::fprintf(stderr, "the operator's page is %s\n", secret.c_str());
    if (!_address.isLoopback())
        std::fprintf(stderr,
                     "the operator's page can be seen by all who reach %s, and is not encrypted\n",
                     _address.text().c_str());
}

Monitor::~Monitor()
{
    _page->end();
}

int Monitor::port() const
{
    return _address.port;
}

std::string Monitor::url() const
{
    return fmt::format("http://{}/", _address.text());
}

} // namespace midair::samples
