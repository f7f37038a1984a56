#pragma once

#include "samples/shared/monitor/MonitorOptions.h"
#include "samples/shared/monitor/MonitorSource.h"
#include "samples/shared/monitor/page/MonitorAddress.h"

#include <memory>
#include <string>

namespace midair::samples
{

class PageServer;

/// Serves the operator's page of an installation, of whatever kind its source is. For a scene:
/// SceneMonitor.
class Monitor
{
public:
    /// Serves from now on, and says where on stderr. \a name: of the program and what it shows.
    /// \a picture may be null. Throws std::runtime_error if options.address isn't understood or
    /// can't be listened on, or if the token's file can't be used: an operator relies on the page.
    Monitor(const MonitorOptions& options,
            const std::string& name,
            std::shared_ptr<MonitorSource> source,
            std::shared_ptr<PictureSource> picture = nullptr,
            const PageLimits& limits = PageLimits());
    ~Monitor();
    Monitor(const Monitor&) = delete;
    Monitor& operator=(const Monitor&) = delete;

    int port() const;
    std::string url() const; ///< "http://127.0.0.1:8080/"
    const std::string& token() const { return _token; }

private:
    MonitorAddress _address;
    std::string _token;
    std::shared_ptr<PageServer> _page;
};

} // namespace midair::samples
