// midair-referee: plays moving scenes into recordings, recomputes every figure of every report from
// the levels in the file, in double, and fails where one is off by more than 1 % of itself.
#include "tests/referee/Verdict.h"

#include <cstdio>
#include <filesystem>

#include <CLI/CLI.hpp>
#include <unistd.h>

using namespace midair::referee;

namespace
{

void print(const Scene& scene, const Verdict& verdict)
{
    std::printf("%s: %d updates, %d skipped, %s\n",
                scene.name.c_str(),
                verdict.updates,
                verdict.skipped,
                verdict.passed() ? "true" : "FALSE");
    std::printf("  %-30s %9s  %12s %12s  %6s  %9s %6s\n",
                "figure",
                "off %",
                "told",
                "recomputed",
                "update",
                "apart",
                "fails");
    for (const auto& [name, worst] : verdict.figures)
        std::printf("  %-30s %9.4f  %12.6g %12.6g  %6d  %9.2g %6d\n",
                    name.c_str(),
                    100.0 * worst.off,
                    worst.told,
                    worst.truth,
                    worst.update,
                    worst.apart,
                    worst.failures);
    for (const std::string& name : verdict.missing)
        std::printf("  %-30s is recomputed by nobody\n", name.c_str());
    std::printf("  rows kept for moves up to %.0f nm: rms where asked up to %.4f %%, %.4f %% more "
                "than told (at most %.2f %%)\n",
                1e9 * verdict.worstMove_m,
                100.0 * verdict.rmsAsked,
                100.0 * verdict.rmsAdded,
                100.0 * verdict.mostAdded);
    if (verdict.overCap > 0.0) std::printf("  loudest point %.5f of the cap\n", verdict.overCap);
    std::fflush(stdout);
}

} // namespace

int main(int argc, char** argv)
{
    CLI::App app{"Recomputes every figure of the reports of moving scenes from the levels played"};
    int updates = 1000;
    std::string only;
    app.add_option("--updates", updates, "of each scene")
        ->check(CLI::Range(1, 1000000))
        ->capture_default_str();
    app.add_option("--only", only, "scenes whose name contains this");
    CLI11_PARSE(app, argc, argv);
    const std::filesystem::path file = std::filesystem::temp_directory_path() /
                                       ("midair-referee-" + std::to_string(::getpid()) + ".midair");
    int judged = 0, failed = 0;
    try
    {
        for (const Scene& scene : allScenes())
        {
            if (scene.name.find(only) == std::string::npos) continue;
            const Verdict verdict = judge(record(scene, updates, file.string()));
            std::filesystem::remove(file);
            print(scene, verdict);
            ++judged;
            failed += verdict.passed() ? 0 : 1;
        }
    }
    catch (const std::exception& error)
    {
        std::fprintf(stderr, "midair-referee: %s\n", error.what());
        std::filesystem::remove(file);
        return 1;
    }
    std::printf("%d of %d scenes are told truly\n", judged - failed, judged);
    return judged > 0 && failed == 0 ? 0 : 1;
}
