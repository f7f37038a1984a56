// Stands in for DesignerServer where WebSocket++ is missing.
#include "haptics/base/InputError.h"
#include "samples/tools/sense/DesignerServer.h"

namespace midair::samples
{

class DesignerServer::Endpoint
{
};

DesignerServer::DesignerServer(SenseOutput& /*output*/,
                               const DesignerServerOptions& /*options*/,
                               std::function<void(const std::string&)> /*tell*/)
{
    throw base::InputError("--serve isn't in this build: it was compiled without WebSocket++ "
                           "(libwebsocketpp-dev, libasio-dev)");
}

DesignerServer::~DesignerServer() = default;

int DesignerServer::port() const
{
    return 0;
}

void DesignerServer::run(const std::function<bool()>& /*isStopAsked*/) {}

void DesignerServer::stop() {}

} // namespace midair::samples
