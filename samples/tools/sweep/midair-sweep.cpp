// Solves for every row of a table of parameters, on one core or on many machines, and writes one
// table of results.

#include "haptics/base/InputError.h"
#include "samples/tools/sweep/Sweep.h"

#include <cstdio>
#include <exception>

#include <CLI/CLI.hpp>

int main(int argc, char** argv)
{
    using namespace midair::samples;
    using midair::base::InputError;
    constexpr int kWrong = 2;
    SweepArguments arguments;
    std::vector<std::string> parts;
    CLI::App app("midair-sweep: solves for every row of a table of parameters, which are "
                 "midair-solve's options and settings by their names, and writes a CSV with the "
                 "figures of each. What is finished is kept when it is ended: the same command "
                 "goes on.\n"
                 "Exit code: 0 done, 1 done but for rows that can't be solved, 2 something is "
                 "wrong.",
                 "midair-sweep");
    app.add_option("table", arguments.table, "TABLE.csv or TABLE.json");
    app.add_option("--out", arguments.out, "Table of results; with --shard the part")->required();
    app.add_option("--shard",
                   arguments.shard,
                   "i/K: every K-th piece of 16 rows from the i-th on; the same bytes for any K")
        ->capture_default_str();
    app.add_option("--merge", parts, "Parts of all shards, which become the table of results");
    app.add_flag("--times",
                 arguments.times,
                 "Columns of the times that solves took, too, which differ each time");
    app.add_flag("--overwrite", arguments.overwrite, "Replace --out even if it is something else");
    app.add_flag("--quiet", arguments.quiet, "No progress");
    try
    {
        app.parse(argc, argv);
        if (parts.empty() && arguments.table.empty())
            throw InputError("name a table, or --merge PARTS");
        if (parts.empty()) return sweep(arguments);
        if (!arguments.table.empty()) throw InputError("--merge takes parts, and no table");
        mergeSwept(parts, arguments.out, arguments.overwrite);
        return 0;
    }
    catch (const CLI::ParseError& error)
    {
        return app.exit(error) == 0 ? 0 : kWrong;
    }
    catch (const std::exception& error)
    {
        std::fprintf(stderr, "midair-sweep: %s\n", error.what());
        return kWrong;
    }
}
