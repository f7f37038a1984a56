#pragma once

#include <string>
#include <vector>

namespace CLI
{
class App;
}

namespace midair::samples
{

/// What the command line says about the operator's page.
struct MonitorOptions
{
    std::string address; ///< "ADDRESS:PORT"; empty: there is no page
    /// file with the token that mutes and unmutes; made if it is missing. Empty: a new token with
    /// each start, which is printed
    std::string tokenFile;
    /// names of this machine, besides localhost and its own, under which the page is asked for
    std::vector<std::string> hosts;
};

/// Adds --monitor, --monitor-token-file and --monitor-host. \a options must outlive the parsing.
void addMonitorOptions(CLI::App& app, MonitorOptions& options);

} // namespace midair::samples
