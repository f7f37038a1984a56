#include "tests/benchmarks/solver/Reflected.h"

#include "tests/benchmarks/Timing.h"

#include <algorithm>
#include <cstdio>

namespace midair::bench
{

namespace
{

constexpr int kKinds = 3;

// Nothing, a plane without end, a rectangle.
std::vector<haptics::Reflector> reflectorsOf(int kind)
{
    haptics::Reflector table;
    table.position = {0.0, -0.2, 0.0};
    table.normal = Eigen::Vector3d::UnitY();
    table.accuracy_mm = 0.1;
    if (kind == 2) table.size_m.setConstant(0.6);
    return kind == 0 ? std::vector<haptics::Reflector>{} : std::vector<haptics::Reflector>{table};
}

} // namespace

void printReflected(const std::vector<Cell>& cells, int rounds)
{
    std::printf("processor time of an update, median of %d rounds in turn; rms of the points\n",
                rounds);
    for (Cell cell : cells)
    {
        if (cell.mode != "update") continue;
        cell.surface = false;
        std::vector<double> cpu[kKinds], rms[kKinds], ratio[kKinds];
        for (int round = 0; round < rounds; ++round)
            for (int kind = 0; kind < kKinds; ++kind)
            {
                cell.reflectors = reflectorsOf(kind);
                const Result result = run(cell);
                cpu[kind].push_back(result.cpu_ms);
                rms[kind].push_back(result.rms);
                ratio[kind].push_back(result.cpu_ms / cpu[0].back());
            }
        std::printf("%-8s n %3d  free %.3f ms, %.4f %%",
                    cell.kase.c_str(),
                    cell.points,
                    median(cpu[0]),
                    100.0 * median(rms[0]));
        for (int kind = 1; kind < kKinds; ++kind)
            std::printf("  %s %.3f ms, x %.2f (%.2f .. %.2f), %.4f %%",
                        kind == 1 ? "plane" : "table",
                        median(cpu[kind]),
                        median(ratio[kind]),
                        *std::min_element(ratio[kind].begin(), ratio[kind].end()),
                        *std::max_element(ratio[kind].begin(), ratio[kind].end()),
                        100.0 * median(rms[kind]));
        std::printf("\n");
        std::fflush(stdout);
    }
}

} // namespace midair::bench
