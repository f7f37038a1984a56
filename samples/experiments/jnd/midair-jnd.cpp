// midair-jnd: the paper's two experiments, for a participant or a simulated one.

#include "samples/experiments/jnd/JndCommands.h"
#include "samples/experiments/jnd/JndInstallation.h"

#include <cstdio>
#include <exception>
#include <filesystem>
#include <string>

namespace
{

using namespace midair::samples;

/// Prints what was found, and draws it beside the file of results.
int conclude(const JndInstallation& installation)
{
    if (!installation.log()) return 0;
    const TrialFile& session = installation.log()->results();
    std::printf("%s", summaryOf(session).c_str());
    if (session.trials.empty()) return 0;
    std::string picture = installation.resultsFile();
    if (picture.size() > 4 && picture.compare(picture.size() - 4, 4, ".csv") == 0)
        picture.resize(picture.size() - 4);
    try
    {
        drawSession(session, picture + ".png");
        // It holds what the results do, and is as much the participant's.
        std::filesystem::permissions(picture + ".png",
                                     std::filesystem::perms::owner_read |
                                         std::filesystem::perms::owner_write);
    }
    catch (const std::exception& error)
    {
        std::fprintf(stderr, "midair-jnd: %s\n", error.what());
        return 1;
    }
    return 0;
}

} // namespace

int main(int argc, char** argv)
{
    const std::string command = argc > 1 ? argv[1] : "";
    if (command == "rehearse") return rehearseCommand(argc - 1, argv + 1);
    if (command == "plot") return plotCommand(argc - 1, argv + 1);
    JndInstallation installation;
    const int status = runInstallation(installation, argc, argv);
    const int drawn = conclude(installation);
    return status != 0 ? status : drawn;
}
