// midair-sensation-bench [FILE or CLASSIC]..: processor time of a sample of each, of all classics
// if none is given, on one core, at 1,000 fields a second; then how circles play in real time on a
// simulated device and on one that does nothing, beside a loop that only wakes as often.
#include "haptics/sensation/SensationClassics.h"
#include "haptics/sensation/SensationEvaluator.h"
#include "haptics/sensation/SensationPlayer.h"
#include "haptics/sensation/SensationReader.h"
#include "tests/benchmarks/Timing.h"
#include "tests/benchmarks/sensation/Played.h"

#include <cstdio>
#include <exception>
#include <memory>
#include <string>
#include <vector>

using namespace midair::haptics;

namespace
{

void printSamples(const std::vector<std::string>& names)
{
    constexpr int kSamples = 20000;
    std::printf("%-32s %12s %15s\n", "us a sample (median of 9)", "played", "as AdapTics");
    for (const std::string& name : names)
    {
        const auto sensation = std::make_shared<const Sensation>(loadSensation(name));
        const SensationEvaluator evaluator(sensation);
        double sum = 0.0;
        const double played_ms = midair::bench::median_ms(9,
                                                          [&]
                                                          {
                                                              SensationPlayer player(sensation);
                                                              for (int k = 0; k < kSamples; ++k)
                                                                  sum +=
                                                                      player.sampleAt(k).intensity;
                                                          });
        const double evaluated_ms =
            midair::bench::median_ms(9,
                                     [&]
                                     {
                                         const SensationValues values(*sensation);
                                         SensationState state;
                                         for (int k = 0; k < kSamples; ++k)
                                             sum += evaluator.evaluate(k, values, state).intensity;
                                     });
        std::printf("%-32s %12.3f %15.3f%s\n",
                    name.substr(name.rfind('/') + 1).c_str(),
                    1e3 * played_ms / kSamples,
                    1e3 * evaluated_ms / kSamples,
                    sum < 0.0 ? " " : "");
    }
}

void printRow(const char* name, const midair::bench::PlayedFigures& played)
{
    std::printf("%-16s %9.1f %7.2f %% %10.3f (%5.3f) %4.1f %%",
                name,
                played.fields_Hz,
                100.0 * played.skipped,
                played.late_ms[0],
                played.late_ms[1],
                100.0 * played.core);
    if (played.frequency_Hz > 0.0)
        std::printf(" %10.3f (%7.3f) %11.4f (%6.4f)",
                    played.away_mm[0],
                    played.away_mm[1],
                    played.frequency_Hz,
                    played.mostJump_turns);
    std::printf("\n");
}

void printPlayed()
{
    constexpr double kDuration_s = 10.0;
    std::printf("\n%-16s %9s %9s %18s %6s %20s %20s\n",
                "circles",
                "fields/s",
                "skipped",
                "late ms (99 %)",
                "core",
                "focus mm (largest)",
                "turns Hz (jump)");
    printRow("none: wakes only", midair::bench::wakeOnly(kDuration_s));
    printRow("1", midair::bench::playCircles(1, "sim:", kDuration_s));
    printRow("10", midair::bench::playCircles(10, "sim:", kDuration_s));
    printRow("10 on null:", midair::bench::playCircles(10, "null:", kDuration_s));
    printRow("none: wakes only", midair::bench::wakeOnly(kDuration_s));
}

} // namespace

int main(int argc, char** argv)
{
    try
    {
        const std::vector<std::string> names(argv + 1, argv + argc);
        printSamples(names.empty() ? sensationClassics() : names);
        printPlayed();
    }
    catch (const std::exception& error)
    {
        std::fprintf(stderr, "midair-sensation-bench: %s\n", error.what());
        return 2;
    }
    return 0;
}
