// How long fields round bodies and screens take, and how wrong those are that the solver makes with
// a plate's images. A ball against its series is in the tests.

#include "haptics/base/Units.h"
#include "haptics/propagation/Exposure.h"
#include "haptics/propagation/PressureField.h"
#include "haptics/scattering/RigidBody.h"
#include "haptics/scattering/ScatteringSolver.h"
#include "haptics/scattering/ThinScreen.h"
#include "samples/tools/solve/SolveHand.h"
#include "tests/benchmarks/Timing.h"
#include "tests/haptics/scattering/Plates.h"
#include "tests/haptics/scattering/Scattered.h"
#include "tests/haptics/solvers/ScenePoints.h"

#include <cmath>
#include <cstdio>
#include <ctime>
#include <exception>
#include <limits>
#include <memory>
#include <utility>
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

/// Places of a sphere of 0.5 m around the points, on the side of the units and of what is between
/// them and the plate.
Eigen::Matrix3Xd earsBefore(double z_m)
{
    constexpr int kPlaces = 5000;
    Eigen::Matrix3Xd places(3, kPlaces);
    Eigen::Index count = 0;
    for (int i = 0; i < kPlaces; ++i)
    {
        const double z = 1.0 - (2.0 * i + 1.0) / kPlaces, turn = i * M_PI * (3.0 - std::sqrt(5.0));
        const double out = 0.5 * std::sqrt(1.0 - z * z);
        const Eigen::Vector3d at(out * std::cos(turn), out * std::sin(turn), 0.15 + 0.5 * z);
        if (at.z() < z_m) places.col(count++) = at;
    }
    return places.leftCols(count);
}

void printPlates(int threads)
{
    std::printf("plates behind 100 points on a ball of 30 mm, four AUTD3 units 150 mm before them: "
                "rms of the field solved in free air, and with images; loudest at 0.5 m, with the "
                "plate over without, by images (units shade) and by the screen (they do not)\n");
    const Eigen::Vector3d centre(0.0, 0.0, 0.15);
    const haptics::ControlPoints points = haptics::spherePoints(100, 0.03, centre);
    const haptics::TransducerArray free = midair::test::fourUnits();
    const Eigen::VectorXcf alone = midair::test::driveFor(points, free);
    const double sizes_m[][2] = {{0.1, 0.04}, {0.2, 0.1}, {0.4, 0.1}};
    for (const auto& [side_m, behind_m] : sizes_m)
    {
        haptics::TransducerArray array = free;
        array.reflectors = {midair::test::plateBehind(centre, side_m, behind_m)};
        haptics::ScatteredField truth =
            midair::test::truthOf(array.reflectors.front(), free, threads);
        const auto errorOf = [&](const Eigen::VectorXcf& q)
        { return midair::test::rmsError(midair::test::pressuresOf(q, points.positions, truth)); };
        const double before = errorOf(alone);
        const Eigen::Matrix3Xd ears = earsBefore(0.15 + behind_m - 0.02);
        const auto told_Pa2 = [&](const haptics::TransducerArray& of)
        { return haptics::Exposure(of, haptics::Medium(), ears).heard_Pa2({alone}).maxCoeff(); };
        const double told_dB = 10.0 * std::log10(told_Pa2(array) / told_Pa2(free));
        const double true_dB =
            20.0 * std::log10(midair::test::pressuresOf(alone, ears, truth).cwiseAbs().maxCoeff() /
                              haptics::pressureAt(ears, free, haptics::Medium(), alone, threads)
                                  .cwiseAbs()
                                  .maxCoeff());
        const double after = errorOf(midair::test::driveFor(points, array));
        std::printf("%3.0f mm at %3.0f mm: %5.2f %%, %4.2f %%; %+.1f dB, %+.1f dB\n",
                    1e3 * side_m,
                    1e3 * behind_m,
                    100.0 * before,
                    100.0 * after,
                    told_dB,
                    true_dB);
    }
}

/// Prints the true rms after each correction.
void printRounds(const char* what,
                 const haptics::ControlPoints& points,
                 const haptics::TransducerArray& rows,
                 const std::shared_ptr<haptics::ScatteredField>& truth,
                 int threads,
                 bool hasOptics = true)
{
    std::printf("%s:", what);
    haptics::SolverOptions options;
    options.threads = threads;
    haptics::ScatteringSolver solver(
        haptics::makeSolver("gauss-newton", options),
        truth,
        [](int, double rms) { std::printf(" %.3f", 100.0 * rms); },
        haptics::ScatteringSolver::kRounds,
        hasOptics);
    Eigen::VectorXcf q;
    const double begin_s = processor_s();
    solver.solve(points, rows, haptics::Medium(), q);
    std::printf(" %%; %.1f s of processor time\n", processor_s() - begin_s);
}

void printBody(const char* where,
               const haptics::ControlPoints& points,
               const haptics::TransducerArray& array,
               haptics::RigidBody body,
               int threads)
{
    std::printf("%s, octagon\n", where);
    const auto truth = std::make_shared<haptics::ScatteredField>(
        std::vector<std::shared_ptr<const haptics::Scatterer>>{
            std::make_shared<haptics::RigidBody>(std::move(body))},
        array,
        haptics::Medium(),
        threads);
    printRounds("  physical optics in the rows", points, array, truth, threads);
    printRounds("  free rows", points, array, truth, threads, false);
}

void printCorrections(int threads)
{
    std::printf("100 points on a ball of 30 mm, corrected for what stands beside them: true rms "
                "without, and after each correction\n");
    const Eigen::Vector3d centre(0.0, 0.0, 0.15);
    const haptics::TransducerArray free = midair::test::fourUnits();
    for (const auto& [side_m, behind_m] : {std::pair{0.2, 0.1}, std::pair{0.1, 0.04}})
    {
        haptics::TransducerArray array = free;
        array.reflectors = {midair::test::plateBehind(centre, side_m, behind_m)};
        const haptics::Reflector& plate = array.reflectors.front();
        std::printf(
            "%3.0f mm at %3.0f mm behind, four AUTD3 units\n", 1e3 * side_m, 1e3 * behind_m);
        const haptics::ControlPoints points = haptics::spherePoints(100, 0.03, centre);
        const auto truth =
            std::make_shared<haptics::ScatteredField>(midair::test::truthOf(plate, free, threads));
        printRounds("  images in the rows", points, array, truth, threads);
        printRounds("  free rows", points, free, truth, threads);
    }
    const haptics::TransducerArray octagon = haptics::TransducerArray::octagonalPrism();
    const haptics::ControlPoints points = haptics::spherePoints(100, 0.03);
    haptics::TriangleMesh finger =
        midair::test::ballOf(8e-3, kWavelength_m / haptics::RigidBody::kElements);
    finger.vertices.colwise() += Eigen::Vector3d(0.039 * points.normals.col(50));
    printBody("a ball of 8 mm, 1 mm off the points",
              points,
              octagon,
              {haptics::RigidBody::divided(finger, kWavelength_m), kWavelength_m, threads},
              threads);
}

/// A hand that comes from above and points at the topmost point.
void printHand(Eigen::Index elements, int threads)
{
    const double begin_s = processor_s();
    haptics::ClosedBody body = haptics::ClosedBody::from(samples::handMesh(elements),
                                                         std::numeric_limits<double>::infinity(),
                                                         haptics::RigidBody::kMostElements);
    const double meshed_s = processor_s();
    std::printf("a hand of %ld elements, %.1f a wavelength, %.0f MB: %.1f s of processor time",
                static_cast<long>(body.size()),
                kWavelength_m / body.meanSide_m(),
                1e-6 * haptics::RigidBody::bytesFor(body.size()),
                meshed_s - begin_s);
    haptics::RigidBody hand(std::move(body), kWavelength_m, threads);
    std::printf(", its matrix %.1f s\n", processor_s() - meshed_s);
    const haptics::TransducerArray octagon = haptics::TransducerArray::octagonalPrism();
    const haptics::ControlPoints points = haptics::spherePoints(100, 0.03);
    const Eigen::Vector3d up = samples::openSideOf(octagon),
                          pad = samples::padAbove(points.positions, up);
    haptics::RigidBody lying = hand;
    hand.moveBy(samples::pointingAt(pad, up));
    printBody("  pointing at the topmost point", points, octagon, std::move(hand), threads);
    // At rest its fingers point to -z, its palm to -y.
    lying.moveBy(
        Eigen::Isometry3d(Eigen::Translation3d(pad - lying.body().corners.row(1).minCoeff() * up)));
    printBody("  lying with its palm over it", points, octagon, std::move(lying), threads);
}

int run(int argc, char** argv)
{
    CLI::App app("Fields round rigid bodies and screens, at 40 kHz");
    std::vector<double> sides_m{0.06, 0.12, 0.213};
    std::vector<double> radii_m{0.004, 0.011, 0.021};
    int threads = 2;
    Eigen::Index elements = haptics::RigidBody::kMostElements;
    app.add_option("--sides", sides_m, "of square screens, m")->capture_default_str();
    app.add_option("--radii", radii_m, "of balls, m")->capture_default_str();
    app.add_option("--elements", elements, "of a hand, at most")->capture_default_str();
    app.add_option("--threads", threads)->check(CLI::Range(1, 64))->capture_default_str();
    CLI11_PARSE(app, argc, argv);
    printPlates(threads);
    printCorrections(threads);
    printHand(elements, threads);
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
