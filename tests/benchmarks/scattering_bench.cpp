// How long fields round bodies and screens take, and how wrong they are: a ball against its series
// is in the tests; here, processor time and memory.

#include "haptics/base/Units.h"
#include "haptics/scattering/RigidBody.h"
#include "haptics/scattering/ThinScreen.h"
#include "tests/benchmarks/Timing.h"
#include "tests/haptics/scattering/Scattered.h"

#include <cstdio>
#include <ctime>
#include <exception>
#include <vector>

#include <CLI/CLI.hpp>

namespace
{

using namespace midair;
using midair::test::kWavelength_m;

double processor_s()
{
    return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

const Eigen::Vector3d kSource(0.01, 0.005, 0.08);

void printScreens(const std::vector<double>& sides_m)
{
    std::printf("screens at 8 cells a wavelength: processor time to make, to solve\n");
    for (const double side_m : sides_m)
    {
        const double begin_s = processor_s();
        haptics::ScreenPlate plate;
        plate.size_m = {side_m, side_m};
        const haptics::ThinScreen screen(plate, kWavelength_m);
        const double made_s = processor_s();
        Eigen::VectorXcd jump;
        const haptics::GmresReport report = screen.solve(
            midair::test::fieldOf(kSource, base::kTwoPi / kWavelength_m, screen), jump);
        std::printf("%4.0f mm %7ld cells: %6.2f s, %6.2f s, %d iterations\n",
                    1e3 * side_m,
                    static_cast<long>(screen.places().cols()),
                    made_s - begin_s,
                    processor_s() - made_s,
                    report.iterations);
    }
}

void printBalls(const std::vector<double>& radii_m, int threads)
{
    std::printf("balls at 6 elements a wavelength: processor time to make, to solve; memory\n");
    for (const double radius_m : radii_m)
    {
        const double begin_s = processor_s();
        const haptics::TriangleMesh mesh =
            midair::test::ballOf(radius_m, kWavelength_m / haptics::RigidBody::kElements);
        const haptics::RigidBody ball(
            haptics::RigidBody::divided(mesh, kWavelength_m), kWavelength_m, threads);
        const double made_s = processor_s();
        Eigen::VectorXcd onBall;
        const haptics::GmresReport report = ball.solve(
            midair::test::fieldOf({0.0, 0.0, radius_m + 0.05}, base::kTwoPi / kWavelength_m, ball),
            onBall);
        std::printf("%4.1f mm %7ld elements: %6.2f s, %6.2f s, %d iterations; %.0f MB\n",
                    1e3 * radius_m,
                    static_cast<long>(ball.body().size()),
                    made_s - begin_s,
                    processor_s() - made_s,
                    report.iterations,
                    1e-6 * haptics::RigidBody::bytesFor(ball.body().size()));
    }
}

int run(int argc, char** argv)
{
    CLI::App app("Fields round rigid bodies and screens, at 40 kHz");
    std::vector<double> sides_m{0.06, 0.12, 0.213};
    std::vector<double> radii_m{0.004, 0.011, 0.022};
    int threads = 2;
    app.add_option("--sides", sides_m, "of square screens, m")->capture_default_str();
    app.add_option("--radii", radii_m, "of balls, m")->capture_default_str();
    app.add_option("--threads", threads)->check(CLI::Range(1, 64))->capture_default_str();
    CLI11_PARSE(app, argc, argv);
    printScreens(sides_m);
    printBalls(radii_m, threads);
    return 0;
}

} // namespace

int main(int argc, char** argv)
{
    try
    {
        return run(argc, argv);
    }
    catch (const std::exception& error)
    {
        std::fprintf(stderr, "midair-scattering-bench: %s\n", error.what());
        return 1;
    }
}
