#pragma once

#include <cstddef>
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

/// What strangers may take of this program.
struct PageLimits
{
    std::size_t connections = 64; ///< at a time; for more, the oldest make room
    std::size_t headBytes = 8192; ///< of a request up to its empty line
    double head_s = 5.0;          ///< for a whole request to come, however slowly
    double mute_s = 4.0;          ///< for a mute to be done, before it is said that it hangs
    double write_s = 10.0;        ///< for an answer to be taken
    double drain_s = 1.0;         ///< for the other side to hang up
};

/// Adds --monitor, --monitor-token-file and --monitor-host. \a options must outlive the parsing.
void addMonitorOptions(CLI::App& app, MonitorOptions& options);

} // namespace midair::samples
