#include "samples/shared/monitor/MonitorOptions.h"

#include "samples/shared/monitor/page/MonitorAddress.h"

#include <exception>

#include <CLI/CLI.hpp>

namespace midair::samples
{

namespace
{

std::string problemOfAddress(const std::string& text)
{
    try
    {
        MonitorAddress::parse(text);
    }
    catch (const std::exception& error)
    {
        return error.what();
    }
    return {};
}

} // namespace

void addMonitorOptions(CLI::App& app, MonitorOptions& options)
{
    app.add_option("--monitor",
                   options.address,
                   "Serves the operator's page there: state, picture, figures, mute; \":8080\" is "
                   "127.0.0.1:8080, for this machine alone")
        ->type_name("ADDRESS:PORT")
        ->check(CLI::Validator(problemOfAddress, ""))
        ->group("The operator's page");
    app.add_option("--monitor-token-file",
                   options.tokenFile,
                   "Holds the token that mutes and unmutes; made if it is missing [a new token is "
                   "printed]")
        ->type_name("FILE")
        ->group("The operator's page");
    app.add_option("--monitor-host",
                   options.hosts,
                   "A name by which browsers ask for the page, as behind a proxy; may be repeated")
        ->type_name("NAME")
        ->group("The operator's page");
}

} // namespace midair::samples
