#include "haptics/scattering/RestScattering.h"

#include "haptics/base/InputError.h"
#include "haptics/propagation/PressureField.h"
#include "haptics/scattering/RigidBody.h"
#include "haptics/scattering/ScatteredField.h"
#include "haptics/scattering/ScatteringSolver.h"
#include "haptics/scattering/ThinScreen.h"
#include "haptics/solvers/Solvers.h"

#include <algorithm>
#include <complex>
#include <utility>

#include <fmt/format.h>

namespace midair::haptics
{

namespace
{

/// Memory of a plate's cell: its lattice, padded, and the vectors of GMRES.
constexpr double kBytesPerCell = 500.0;

/// Of all things together: scenes are untrusted.
constexpr double kMostBytes = 1.5e9;

TriangleMesh moved(const ReflectingBody& body)
{
    TriangleMesh mesh = *body.mesh;
    mesh.vertices = body.pose * mesh.vertices;
    return mesh;
}

/// Takes \a some from \a reflectors.
void takeOut(const std::vector<Reflector>& some, std::vector<Reflector>& reflectors)
{
    const auto isOne = [&](const Reflector& one)
    { return std::find(some.begin(), some.end(), one) != some.end(); };
    reflectors.erase(std::remove_if(reflectors.begin(), reflectors.end(), isOne), reflectors.end());
}

} // namespace

RestScattering::Size RestScattering::sizeOf(const RigidThings& things, double wavelength_m)
{
    Size size;
    for (const Reflector& one : things.plates)
        size.elements += ThinScreen::cellsOf(*plateOf(one), wavelength_m).prod();
    size.bytes = kBytesPerCell * size.elements;
    for (const ReflectingBody& body : things.bodies)
    {
        const Eigen::Index count = ClosedBody::count(
            *body.mesh, wavelength_m / RigidBody::kElements, RigidBody::kMostElements);
        size.elements += static_cast<double>(count);
        size.bytes += RigidBody::bytesFor(count);
    }
    return size;
}

void RestScattering::make(const FieldBesideThings& given)
{
    const double wavelength_m = given.medium.wavelength(given.array.frequency_Hz);
    if (given.things == _things && wavelength_m == _wavelength_m) return;
    if (const double bytes = sizeOf(given.things, wavelength_m).bytes; !(bytes <= kMostBytes))
        throw base::InputError(
            fmt::format("it would take {:.0f} MB; at most {:.0f} MB are possible",
                        1e-6 * bytes,
                        1e-6 * kMostBytes));
    _wavelength_m = 0.0; // if it is stopped
    _scatterers.clear();
    for (const Reflector& one : given.things.plates)
        _scatterers.push_back(std::make_shared<ThinScreen>(*plateOf(one), wavelength_m));
    for (const ReflectingBody& body : given.things.bodies)
        _scatterers.push_back(
            std::make_shared<RigidBody>(RigidBody::divided(moved(body), wavelength_m),
                                        wavelength_m,
                                        given.options.threads,
                                        given.options.stop));
    _things = given.things;
    _wavelength_m = wavelength_m;
}

FieldForThings RestScattering::solve(const FieldBesideThings& given)
{
    FieldForThings solved;
    make(given);
    TransducerArray alone = given.heard;
    takeOut(given.things.plates, alone.reflectors);
    takeOut(given.things.faces, alone.reflectors);
    const auto truth = std::make_shared<ScatteredField>(
        _scatterers, std::move(alone), given.medium, given.options.threads, given.options.stop);

    // Its first solve makes the rows; a solver starts from multipliers only after one.
    auto solver = makeSolver(given.solver, given.options);
    Eigen::VectorXcf q;
    solver->solve(given.points, given.array, given.medium, q);
    if (!solver->startFrom(given.multipliers))
    {
        solved.why = "the solver can't go on from the playing field";
        return solved;
    }
    const auto told = [&](int round, double rms)
    {
        if (round == 0) solved.rmsBefore = rms;
    };
    // The faces of bodies that are images in the rows are the optics of these.
    const bool hasOptics = given.things.faces.empty();
    ScatteringSolver correcting(
        std::move(solver), truth, told, ScatteringSolver::kRounds, hasOptics);
    solved.report = correcting.solve(given.points, given.array, given.medium, q);
    given.options.stop.throwIfRequested();
    if (!(solved.report.level_Pa > 0.0))
    {
        solved.why = solved.report.message.empty() ? "there is no field" : solved.report.message;
        return solved;
    }
    truth->setDrive(q);
    const Eigen::VectorXcd whole =
        truth->free_Pa(given.points.positions) + truth->scattered_Pa(given.points.positions);
    solved.outside = {whole - pressureAt(given.points.positions,
                                         given.heard,
                                         given.medium,
                                         q,
                                         given.options.threads,
                                         given.options.stop)
                                  .cast<std::complex<double>>(),
                      q};
    solved.highest_Pa = whole.cwiseAbs().maxCoeff();
    solved.drive = std::move(q);
    return solved;
}

} // namespace midair::haptics
